"""Null recordings keep the noise and lose its order; names of what is left in them are counted."""

from dataclasses import replace

import numpy as np
import pytest

from tasks.explain.explain import explain
from tasks.readings.lattice import quantiser_of
from tests.proof.chance import (
    CHANNELS,
    Accepted,
    answered,
    flipped,
    markdown,
    null_recording,
    reported,
    scrambled,
    torn,
    upper_bound,
)
from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.simulate import simulate

PLANTED = "rate_ripple"
CASE = Case(
    seed=12, procedure="one_axis", rate_hz=20, dwell_s=12.0, rates_deg_s=(20.0, 60.0, 150.0, 250.0),
    effects=(EffectCall(name=PLANTED, strength=0.77),),
)  # fmt: skip
TEARS = (flipped, scrambled)


@pytest.fixture(scope="module")
def planted() -> Accepted:
    """A run whose accepted model lacks what was planted in it."""
    clean, other = simulate(CASE.without(PLANTED)), simulate(CASE)
    return Accepted(other.recording, clean.truth, *[frozenset[str]()] * 3)


def _residual(of: Accepted, recording=None) -> np.ndarray:
    return (recording or of.recording).imu.stack(CHANNELS) - of.found


@pytest.mark.parametrize("tear", TEARS)
def test_a_torn_residual_keeps_its_power_and_forgets_its_order(planted, tear):
    clean = simulate(CASE.without(PLANTED))
    of = replace(planted, recording=clean.recording)
    before = _residual(of)
    after = _residual(of, null_recording(of, tear, np.random.default_rng(1)))
    np.testing.assert_allclose((after**2).mean(axis=0), (before**2).mean(axis=0), rtol=0.1)
    alike = [np.corrcoef(a, b)[0, 1] for a, b in zip(before.T, after.T, strict=True)]
    assert np.abs(alike).max() < 0.3


@pytest.mark.parametrize("tear", TEARS)
def test_a_drift_is_sewn_without_jumps(tear):
    t = np.arange(0.0, 900.0, 0.1)
    drift = np.column_stack([np.sin(2.0 * np.pi * t / period) for period in (90.0, 130.0, 170.0)])
    after = torn(drift, 0.1, tear, np.random.default_rng(2))
    assert np.abs(after - drift).max() > 0.5
    assert np.abs(np.diff(after, axis=0)).max() < 0.05


def test_the_channels_of_a_triad_are_turned_together():
    one = np.random.default_rng(3).normal(size=5000)
    after = torn(np.column_stack([one, one, one]), 0.1, flipped, np.random.default_rng(4))
    fast = after - np.median(after)
    assert np.corrcoef(fast.T)[0, 1:].min() > 0.95


def test_readings_whose_motion_is_unknown_stay(planted):
    found = planted.found.copy()
    found[100:300] = np.nan
    of = replace(planted, found=found)
    null = null_recording(of, flipped, np.random.default_rng(5)).imu.stack(CHANNELS)
    recorded = of.recording.imu.stack(CHANNELS)
    np.testing.assert_allclose(null[100:300], recorded[100:300], atol=1e-9)
    assert (null[300:] != recorded[300:]).mean() > 0.3


def test_a_null_recording_has_the_codes_of_the_recording(planted):
    null = null_recording(planted, scrambled, np.random.default_rng(8)).imu.stack(CHANNELS)
    for own, recorded in zip(null.T, planted.recording.imu.stack(CHANNELS).T, strict=True):
        codes = quantiser_of(recorded)
        assert quantiser_of(own).step == pytest.approx(codes.step)
        assert np.abs(codes.codes(own) - (own - codes.offset) / codes.step).max() < 1e-6


@pytest.mark.rehearsal
def test_an_effect_that_survives_in_the_residual_is_counted_and_one_that_is_torn_is_not(planted):
    survives = null_recording(planted, lambda parts, _: parts, np.random.default_rng(6))
    rows = [answered({"kind": "flipped", "label": "made", "draw": 0}, survives, planted)]
    torn_ = null_recording(planted, flipped, np.random.default_rng(7))
    rows.append(answered({"kind": "flipped", "label": "made", "draw": 1}, torn_, planted))
    assert [row["wrong"] for row in rows] == [[PLANTED], []]
    known = replace(planted, unreported=frozenset({PLANTED}))
    again = reported(explain(planted.recording), known)
    assert (again["wrong"], again["returned"]) == ([], [PLANTED])
    page = markdown(rows, "this")
    assert "| 2 | 1 | 1 | 90.5 % |" in page
    assert f"| flipped | made | 0 | {PLANTED} | – |" in page


def test_without_a_wrong_name_381_recordings_show_a_rate_below_one_per_cent():
    assert upper_bound(0, 380) > 0.01 > upper_bound(0, 381)
