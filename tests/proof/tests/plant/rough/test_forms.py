"""Forms of listed effects that differ from the plain plant's, and what is outside the catalogue."""

import json

import numpy as np
import pytest

from tests.proof.plant.effects import CATALOGUE
from tests.proof.plant.rough.forms import FORMS, KNOWN, RigMode, catalogue_name
from tests.proof.plant.rough.play import LARGEST, at_standing, standing
from tests.proof.tests.plant.rough.short_runs import excess, played, rough_of

NEW = {
    "range_setting", "axis_mapping", "dead_zone", "code_fault", "repeated_samples",
    "timestamp_jitter",
}  # fmt: skip


def test_names_are_the_catalogue_s_or_marked() -> None:
    for form in FORMS:
        name = catalogue_name(form)
        assert name in CATALOGUE or name in NEW or name == form.lower(), form
        assert name.startswith("x_") or form.startswith(name)
    assert {catalogue_name(form) for form in FORMS} > NEW


@pytest.mark.parametrize("form", sorted(FORMS))
def test_every_form_changes_what_is_recorded_and_says_its_parameters(form: str) -> None:
    run = played(rough_of("shaft", form))
    declared = run.sealed["effects"][0]
    assert declared["called"] == form
    assert set(declared["parameters"]) == set(KNOWN[form].units)
    assert json.dumps(run.sealed)
    assert standing(run, played(rough_of("shaft")), by_size=True) > 2.0


def test_play_grows_with_the_angle_slips_and_keeps_at_rest() -> None:
    run = played(rough_of("shaft", "hysteresis_play", amplitude=[1e-3, 0.0, 0.0], width=0.2))
    rate = run.reported[:, 0]
    bias, angle = excess(run)[0], (np.cumsum(rate) - rate / 2.0) * 0.01
    first = np.flatnonzero(np.abs(angle) > 1e-3)[0]
    growing = slice(first, first + np.flatnonzero(np.abs(angle[first:]) > 0.18)[0])
    assert bias[growing] == pytest.approx(1e-3 * angle[growing] / 0.2, abs=3e-5)
    assert np.abs(bias).max() == pytest.approx(1e-3, rel=1e-3)
    rest = np.abs(run.reported[:, 0]) < 1e-6
    assert np.abs(np.diff(bias))[rest[1:] & rest[:-1]].max() < 1e-7


def test_preisach_keeps_the_largest_rate_in_mind() -> None:
    centre, half = [0.0, 0.0], [0.1, 0.9]
    run = played(rough_of("shaft", "hysteresis_preisach", amplitude=[1e-3, 0, 0], centre=centre,
                          half=half, top_rate=1.0))  # fmt: skip
    bias, rate = excess(run)[0], run.reported[:, 0]
    after_slow = (np.maximum.accumulate(np.abs(rate)) > 0.9) & (np.abs(rate) < 1e-6)
    assert set(np.round(bias[after_slow] / 1e-3, 3)) <= {-1.0, 0.0, 1.0}
    assert bias[rate > 0.95].min() == pytest.approx(1e-3, rel=1e-2)


def test_hysteresis_with_decay_fades_at_rest() -> None:
    run = played(rough_of("shaft", "hysteresis_decay", amplitude=[1e-3, 0, 0], angle=0.1, tau=2.0))
    bias = np.abs(excess(run)[0])
    assert bias[-1] == pytest.approx(bias[-201] * np.exp(-1.0), rel=0.02)


def test_a_step_of_single_axes_falls_within_a_move() -> None:
    run = played(rough_of("shaft", "bias_step_moving"))
    declared = run.sealed["effects"][0]["parameters"]
    at = np.searchsorted(run.recording.imu.t, declared["time"])
    assert abs(run.reported[at, 0]) > 0.1
    assert 1 <= np.count_nonzero(declared["gyro"] + declared["accel"]) <= 2


@pytest.mark.parametrize(("form", "power"), [("speed", 1.0), ("square", 2.0)])
def test_rectification_follows_the_speed_or_its_square(form: str, power: float) -> None:
    run = played(rough_of("hand", f"vibration_rectification_{form}", coefficient=[0.1, 0, 0]))
    speed = np.linalg.norm(run.reported[:, :3], axis=1)
    fast = speed > 0.5
    slope = np.polyfit(np.log(speed[fast]), np.log(excess(run)[3, fast]), 1)[0]
    assert slope == pytest.approx(power, abs=0.02)


def test_late_temperature_lags_behind_the_thermometer() -> None:
    run = played(
        rough_of("shaft", "temperature_bias_late", gyro=[1e-3, 0, 0], accel=[0] * 3, tau=20.0)
    )
    own = run.recording.imu.columns["temperature"]
    follows = excess(run)[0] / 1e-3 + 25.0
    assert follows[-1] - follows[0] < 0.75 * (own[-200:].mean() - own[:200].mean())


def test_rig_mode_is_still_at_low_and_swings_at_its_own_frequency() -> None:
    run = played(rough_of("shaft", "x_rig_mode", frequency=8.0, damping=0.03))
    swing = run.truth[:, 0] - played(rough_of("shaft")).truth[:, 0]
    spectrum = np.abs(np.fft.rfft(swing * np.hanning(len(swing))))
    assert np.fft.rfftfreq(len(swing), 0.01)[spectrum.argmax()] == pytest.approx(8.0, abs=0.4)
    assert RigMode.at({"frequency": 8.0, "damping": 0.1}, 4.0)["frequency"] == 4.0


def test_backlash_keeps_between_the_flanks() -> None:
    run = played(rough_of("shaft", "x_backlash", half=0.01))
    difference = np.cumsum(run.truth[:, 0] - played(rough_of("shaft")).truth[:, 0]) * 0.01
    assert np.ptp(difference) == pytest.approx(0.02, rel=0.12)


def test_standing_is_the_size_over_everything_else() -> None:
    once = played(rough_of("shaft", "bias_step", gyro=[1e-3, 0, 0], accel=[0] * 3, time=20.0))
    twice = played(rough_of("shaft", "bias_step", gyro=[2e-3, 0, 0], accel=[0] * 3, time=20.0))
    rest = played(rough_of("shaft"))
    assert standing(twice, rest) == pytest.approx(2.0 * standing(once, rest), rel=0.02)
    coarse = {"encoder": {"rate_hz": 100, "step": 0.02, "noise": 0.0}}
    drift = rough_of("shaft", "x_gain_drift", fields=coarse)
    hidden = standing(played(drift), played(drift.without("x_gain_drift")))
    fine = rough_of("shaft", "x_gain_drift")
    assert hidden < 0.7 * standing(played(fine), rest)


def test_an_effect_is_sized_to_stand_where_asked() -> None:
    rough, reached = at_standing(rough_of("shaft", "hysteresis_play", "x_gain_drift"),
                                 "hysteresis_play", 50.0)  # fmt: skip
    assert reached == pytest.approx(50.0, rel=0.15)
    assert rough.case.effects[0].strength != 1.0
    assert rough.case.effects[1].strength == 1.0


def test_nothing_is_made_larger_than_a_working_unit_has_it() -> None:
    coarse = {"encoder": {"rate_hz": 100, "step": 0.02, "noise": 0.01}}
    rough, reached = at_standing(
        rough_of("shaft", "gyro_scale_asymmetry", fields=coarse), "gyro_scale_asymmetry", 1e4
    )
    assert rough.case.effects[0].strength == LARGEST
    assert reached < 1e4
