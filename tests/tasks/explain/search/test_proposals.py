"""Times of jumps and periods of waves are read off the whitened residual."""

import numpy as np
import pytest
from engine_run import NOISY, RATE, motion, noise, observed, read

from tasks.explain.channels import ACCELS, EVERY, GYROS
from tasks.explain.search.candidates import (
    Candidate,
    candidates_of,
    columns_of,
    plausible_half_ranges,
)
from tasks.explain.search.design import BandedDesign, banded_design, with_columns
from tasks.explain.search.empirical_terms import sinusoid
from tasks.explain.search.proposals import OVERSAMPLING, STEP_DISTANCE, with_proposed_shapes
from tasks.explain.search.stepwise import initial_noises
from tasks.model.term import Term
from tasks.model.terms.environment import TEMPERATURE_BIAS
from tasks.model.terms.memory import bias_step

RUN = motion()
TERMS: tuple[Term, ...] = (
    bias_step(0, 200.0), bias_step(3, 200.0), TEMPERATURE_BIAS,
    sinusoid(EVERY), sinusoid(GYROS), sinusoid(GYROS), sinusoid(ACCELS),
)  # fmt: skip


def proposed(made: np.ndarray, seed: int) -> tuple[BandedDesign, list[Candidate], list[Candidate]]:
    """The pool after proposals, the candidates before and after."""
    blocks = observed(read(RUN) + made + noise(len(RUN.t), seed, NOISY), RUN)
    listed, columns = candidates_of(TERMS, RUN)
    half = plausible_half_ranges(listed, len(columns))
    pool = banded_design(blocks, blocks.readings, columns, half)
    noises = initial_noises(pool)
    pool, moved = with_proposed_shapes(pool, listed, noises)
    return pool, list(listed), moved


def times(candidates: list[Candidate], channels: set[int], pool: BandedDesign) -> list[float]:
    return [
        one.term.at[0] for one in candidates
        if one.name == "bias_step" and channels == {c for p in one.members for c in pool.columns[p]}
    ]  # fmt: skip


def periods(candidates: list[Candidate], channels: tuple[int, ...]) -> list[float]:
    return [
        one.term.at[0] for one in candidates
        if one.term.parameters == sinusoid(channels).parameters
        and len(one.members) == 2 * len(channels)
    ]  # fmt: skip


@pytest.mark.parametrize(("at", "channel"), [(97.32, 0), (250.04, 2), (310.6, 4)])
def test_the_time_of_a_step_is_found_within_a_block(at: float, channel: int) -> None:
    made = np.zeros((len(RUN.t), 6))
    made[RUN.t >= at, channel] = 8.0 * np.sqrt(NOISY[channel].white)
    pool, _, moved = proposed(made, 1)
    assert abs(times(moved, {channel}, pool)[0] - at) <= 1.0 / RATE + 1e-9
    first = 3 * (channel // 3)
    triad = times(moved, {first, first + 1, first + 2}, pool)
    assert abs(triad[0] - at) <= 1.0 / RATE + 1e-9


def test_two_steps_are_both_proposed_and_not_one_of_them_twice() -> None:
    made = np.zeros((len(RUN.t), 6))
    for at, size in ((120.0, 5.0), (300.0, -8.0)):
        made[RUN.t >= at, 1] += size * np.sqrt(NOISY[1].white)
    pool, _, moved = proposed(made, 2)
    found = np.sort(times(moved, {1}, pool))
    assert np.diff(found).min() >= STEP_DISTANCE
    for at in (120.0, 300.0):
        assert np.abs(found - at).min() < 0.5  # the other step is still in the residual


@pytest.mark.parametrize("period", [2.37, 17.3, 61.0])
def test_the_period_of_a_wave_is_found_within_a_percent(period: float) -> None:
    """Where few go into the run, within a point of the spectrum; the fit takes it from there."""
    made = np.zeros((len(RUN.t), 6))
    made[:, 1] = 0.5 * np.sqrt(NOISY[1].white) * np.sin(2.0 * np.pi * RUN.t / period + 0.4)
    _, _, moved = proposed(made, 3)
    near = max(0.01, period / (OVERSAMPLING * 400.0))
    assert periods(moved, GYROS)[0] == pytest.approx(period, rel=near)
    assert periods(moved, EVERY)[0] == pytest.approx(period, rel=near)
    assert len(set(periods(moved, GYROS))) == 2  # what is tried twice is tried at two periods


def test_what_is_proposed_stands_in_the_pool_and_is_charged_for_the_looking() -> None:
    made = np.zeros((len(RUN.t), 6))
    made[RUN.t >= 150.0, 3] = 5.0 * np.sqrt(NOISY[3].white)
    pool, before, after = proposed(made, 4)
    for old, new in zip(before, after, strict=True):
        assert (new.members, new.own, new.name) == (old.members, old.own, old.name)
        if not new.term.shapes or new.prior is not None:
            assert (new.term, new.shape_trials) == (old.term, old.shape_trials)
            continue
        assert new.shape_trials > 10.0
        fresh = columns_of(new.term, RUN)
        for p, q in zip(new.members, new.own, strict=True):
            for channel, series in fresh[q].items():
                np.testing.assert_array_equal(pool.columns[p][channel], series)


def test_what_was_taken_stays_where_it_is() -> None:
    made = np.zeros((len(RUN.t), 6))
    made[RUN.t >= 150.0, 3] = 5.0 * np.sqrt(NOISY[3].white)
    pool, _, moved = proposed(made, 5)
    held = next(one for one in moved if one.name == "bias_step" and len(one.members) == 3)
    noises = initial_noises(pool)
    pool = with_columns(pool, {}, pool.blocks.readings[::-1].copy())
    for selected in ([held], []):
        _, again = with_proposed_shapes(pool, moved, noises, selected)
        (same,) = [one for one in again if one.key == held.key]
        assert (same.term.at == held.term.at) == bool(selected)
