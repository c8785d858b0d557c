"""Three short rough runs: a table, a motor shaft and a body moved by hand."""

import json
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
import pytest

from schemas.recording import ACCEL, GYRO, Stream
from tests.proof.plant.case import (
    GYRO_NOISE,
    Case,
    EffectCall,
    draw_unit,
    inverse,
    product,
    vector_of,
)
from tests.proof.plant.rough.forms import FORMS, KNOWN, RigMode
from tests.proof.plant.rough.play import LARGEST, Played, at_standing, play, standing, without
from tests.proof.plant.rough.runs import Encoder, RoughCase, Tracking, felt, move_by_hand, scattered

FINE = Encoder(rate_hz=100, step=1e-7, noise=0.0)
CLEAR = Tracking(rate_hz=120, position_noise=0.0, attitude_noise=0.0)
RUNS: dict[str, dict[str, Any]] = {
    "table": {"run": "table", "encoder": FINE},
    "shaft": {"run": "shaft", "encoder": FINE, "duration_s": 40.0, "axis": (1.0, 0.0, 0.0)},
    "hand": {"run": "hand", "tracking": CLEAR, "duration_s": 30.0},
}


@lru_cache(maxsize=32)
def _played(text: str) -> Played:
    return play(RoughCase.model_validate_json(text))


def rough_of(
    run: str, *effects: str, fields: dict[str, Any] | None = None, strength: float = 1.0,
    **parameters: Any,
) -> RoughCase:  # fmt: skip
    """A short case of a run with effects; fields replace the case's."""
    calls = tuple(
        EffectCall(name=name, parameters=parameters, strength=strength) for name in effects
    )
    case = Case(seed=6, procedure="one_axis", dwell_s=5.0, rates_deg_s=(100.0,), effects=calls)
    return RoughCase(case=case, **(RUNS[run] | (fields or {})))


def played(rough: RoughCase) -> Played:
    """Plays a case; the same case only once."""
    return _played(rough.model_dump_json())


def excess(run: Played) -> np.ndarray:
    """What the noise-free readings have beyond the standard's model on the reported motion."""
    unit = draw_unit(run.rough.case.seed)
    return run.truth.T - unit.reads(run.reported[:, :3].T, run.reported[:, 3:].T)


def readings(run: Played) -> np.ndarray:
    """The recorded readings, (6, n)."""
    return run.recording.imu.stack(GYRO + ACCEL).T


# Motions that are no procedure: a shaft to and fro, a body moved by hand.


def test_hand_reaches_its_top_rate_and_rests_at_both_ends() -> None:
    run = played(rough_of("hand", fields={"top_rate": 3.5}))
    speed = np.abs(run.reported[:, :3])
    assert speed.max() == pytest.approx(3.5, rel=0.03)
    assert speed[:200].max() < 1e-3
    assert speed[-200:].max() < 1e-3


def test_motion_by_hand_has_no_fast_part() -> None:
    series = played(rough_of("hand")).reported[:, 0]
    power = np.abs(np.fft.rfft(series * np.hanning(len(series)))) ** 2
    frequency = np.fft.rfftfreq(len(series), 0.01)
    assert power[frequency > 12.0].sum() < 1e-4 * power.sum()


def test_specific_force_of_a_moving_body_is_the_second_derivative_of_its_place() -> None:
    rough = RoughCase.model_validate({"case": {"seed": 2}, "run": "hand", "duration_s": 20.0})
    t = np.arange(-1.0, 21.0, 0.002)
    hand = move_by_hand(rough, t)
    still = felt(hand, 9.8, np.zeros(3))
    inertial = still.into_unit(np.array([0.0, 0.0, 9.8]))
    moved = still.force - inertial
    # twice integrated, it leads from where the body rests first to where it rests last
    w, x, y, z = still.attitude
    up = moved[0] * 2 * (x * z - w * y) + moved[1] * 2 * (y * z + w * x)
    up += moved[2] * (w * w - x * x - y * y + z * z)
    risen = np.cumsum(np.cumsum(up)) * 0.002**2
    assert risen[-1] == pytest.approx(hand.place[2, -1] - hand.place[2, 0], abs=2e-3)
    assert np.ptp(hand.place[2]) > 0.05


def test_an_arm_adds_centripetal_and_tangential_force() -> None:
    arm = np.array([0.0, 0.03, 0.0])
    with_arm = rough_of("hand", fields={"tracking": {
        "rate_hz": 120, "position_noise": 0, "attitude_noise": 0, "arm": tuple(arm)
    }})  # fmt: skip
    run, centre = played(with_arm), played(rough_of("hand"))
    rate = run.reported[:, :3]
    change = np.gradient(rate, 0.01, axis=0)
    added = np.cross(change, arm) + np.cross(rate, np.cross(rate, arm))
    gain = np.linalg.inv(np.array(run.sealed["parameters"]["Ka"]))
    difference = (run.truth - centre.truth)[:, 3:] @ gain.T
    assert difference == pytest.approx(added, abs=0.02 * np.abs(added).max())


def test_shaft_turns_both_ways_rests_and_says_nothing_of_segments() -> None:
    run = played(rough_of("shaft"))
    rate = run.reported[:, 0]
    assert rate.max() > 1.0 > -1.0 > rate.min()
    assert (np.abs(rate) < 1e-6).mean() > 0.1
    assert run.recording.manifest.segments is None
    assert list(run.recording.streams()) == ["imu", "table"]


# Encoders and tracked poses that are no better than they are.

DEGREE = np.pi / 180.0


def tracking(**fields: object) -> dict[str, object]:
    declared = {"rate_hz": 120, "position_noise": 0.0, "attitude_noise": 0.0} | fields
    return {"tracking": Tracking.model_validate(declared)}


def test_encoder_has_its_own_rate_steps_and_speeds() -> None:
    coarse = {"encoder": {"rate_hz": 40, "step": 0.3 * DEGREE, "noise": 0.0, "speeds": True}}
    table = played(rough_of("shaft", fields=coarse)).recording.table
    assert table is not None
    assert np.median(np.diff(table.t)) == pytest.approx(1 / 40)
    angle = table.columns["shaft_angle"]
    assert np.allclose(angle / (0.3 * DEGREE), np.rint(angle / (0.3 * DEGREE)))
    assert np.allclose(table.columns["shaft_rate"][1:-1], (angle[2:] - angle[:-2]) * 20)


def test_coarser_steps_mislead_more() -> None:
    misled = [
        played(
            rough_of("shaft", fields={"encoder": {"rate_hz": 100, "step": step, "noise": 0.0}})
        ).misread.std(axis=0)
        for step in (0.01 * DEGREE, 0.3 * DEGREE)
    ]
    assert misled[1][0] > 10 * misled[0][0] > 0.0
    assert misled[1][4] == pytest.approx(9.8 * 0.3 * DEGREE / np.sqrt(12) / np.sqrt(2), rel=0.5)


def test_stamps_scatter_and_still_rise() -> None:
    t = np.arange(5000) * 0.01
    stamps = scattered(np.random.default_rng(1), t, 4e-3)
    assert np.diff(stamps).min() > 0.0
    assert (stamps - t).std() == pytest.approx(4e-3, rel=0.1)
    assert scattered(np.random.default_rng(1), t, 0.0) == pytest.approx(t)


def test_poses_are_turned_against_the_unit_and_the_room() -> None:
    straight = played(rough_of("hand", fields=tracking())).recording.reference
    turned = played(rough_of("hand", fields=tracking(turn=(0.0, 0.03, 0.0)))).recording.reference
    tilted = played(rough_of("hand", fields=tracking(tilt=(0.01, 0.0, 0.0)))).recording.reference
    assert straight is not None
    assert turned is not None
    assert tilted is not None

    def pose(stream: Stream) -> np.ndarray:
        return np.stack([stream.columns[name] for name in ("qw", "qx", "qy", "qz")])

    against = vector_of(product(inverse(pose(turned)), pose(straight)))
    assert np.allclose(against, [[0.0], [0.03], [0.0]], atol=1e-6)
    room = vector_of(product(pose(tilted), inverse(pose(straight))))
    assert np.allclose(room, [[0.01], [0.0], [0.0]], atol=1e-6)
    moved = tilted.columns["pz"] - straight.columns["pz"]
    assert np.allclose(moved, 0.01 * straight.columns["py"], atol=1e-4)


def test_poses_come_late_with_gaps_and_between_the_frames() -> None:
    on_time = played(rough_of("hand", fields=tracking())).recording
    late = played(rough_of("hand", fields=tracking(delay=1 / 120))).recording
    assert on_time.reference is not None
    assert late.reference is not None
    assert late.reference.columns["px"][1:] == pytest.approx(
        on_time.reference.columns["px"][:-1], abs=1e-6
    )
    between = tracking(interpolated=True, gaps=((10.0, 10.5), (20.0, 21.0)))
    held = played(rough_of("hand", fields=between)).recording
    assert held.reference
    assert np.isin(held.reference.t, held.imu.t).all()
    assert np.diff(held.reference.t).max() == pytest.approx(1.0, abs=0.05)
    assert np.linalg.norm([held.reference.columns[q] for q in ("qw", "qx", "qy", "qz")],
                          axis=0) == pytest.approx(1.0)  # fmt: skip


def test_noise_of_poses_and_what_it_does_to_predicted_readings() -> None:
    rough = rough_of("hand", fields=tracking(position_noise=3e-4, attitude_noise=1e-3))
    run, clear = played(rough), played(rough_of("hand", fields=tracking()))
    assert run.recording.reference is not None
    assert clear.recording.reference is not None
    noise = run.recording.reference.columns["px"] - clear.recording.reference.columns["px"]
    assert noise.std() == pytest.approx(3e-4, rel=0.05)
    assert run.misread[:, 3:].std() > 0.1
    assert clear.misread[:, 3:].std() < 0.05 * run.misread[:, 3:].std()


# Forms of listed effects that differ from the plain plant's, and what is outside the catalogue.


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


# What firmware and logger do to the rows.

STEP = GYRO_NOISE["industrial"].step


@pytest.fixture
def pair() -> Callable[..., tuple[np.ndarray, ...]]:
    """Readings without and with an effect on the log."""

    def build(effect: str, **parameters: object) -> tuple[np.ndarray, ...]:
        with_it = readings(played(rough_of("shaft", effect, **parameters)))
        return readings(played(rough_of("shaft"))), with_it

    return build


def test_range_setting_multiplies_one_triad(pair: Callable[..., tuple[np.ndarray, ...]]) -> None:
    without, written = pair("range_setting", triad="gyro", factor=2.0)
    assert written[:3] == pytest.approx(2.0 * without[:3])
    assert (written[3:] == without[3:]).all()


def test_axis_mapping_exchanges_and_inverts(pair: Callable[..., tuple[np.ndarray, ...]]) -> None:
    without, written = pair("axis_mapping", triads=["accel"], order=[1, 0, 2], sign=[1, 1, -1])
    assert (written[3] == without[4]).all()
    assert (written[4] == without[3]).all()
    assert (written[5] == -without[5]).all()
    assert (written[:3] == without[:3]).all()


def test_dead_zone_writes_small_rates_as_zero(pair: Callable[..., tuple[np.ndarray, ...]]) -> None:
    without, written = pair("dead_zone", threshold=0.02)
    small = np.abs(without[:3]) < 0.02
    assert (written[:3][small] == 0.0).all()
    assert (written[:3][~small] == without[:3][~small]).all()


def test_bias_is_taken_off_at_rest_and_stays_off(
    pair: Callable[..., tuple[np.ndarray, ...]],
) -> None:
    without, written = pair("dead_zone_bias_at_rest", wait=0.5, quiet=0.05, tau=0.3)
    taken = without[:3] - written[:3]
    assert np.abs(written[:3, 300:450].mean(axis=1)).max() < 1e-3
    assert np.abs(without[:3, 300:450].mean(axis=1)).max() > 1e-3
    turning = np.abs(without[0]) > 0.5
    assert np.abs(np.diff(taken, axis=1))[:, turning[1:]].max() < 1e-12


def test_stuck_bit_errs_by_its_weight_or_not_at_all(
    pair: Callable[..., tuple[np.ndarray, ...]],
) -> None:
    without, written = pair("code_fault_stuck_bit", channel=1, bit=6, level=1)
    error = np.rint((written[1] - without[1]) / STEP)
    assert set(np.unique(error)) == {0.0, 64.0}
    assert (np.rint(written[1] / STEP).astype(int) & 64 == 64).all()


def test_torn_code_errs_by_256_counts_where_the_low_byte_wraps(
    pair: Callable[..., tuple[np.ndarray, ...]],
) -> None:
    without, written = pair("code_fault_torn", triad="gyro", share=1.0)
    error = np.rint((written[0] - without[0]) / STEP)
    assert (error % 256 == 0).all()
    assert 0 < (error != 0).mean() < 1.0
    code = np.rint(without[0] / STEP).astype(int)
    wrapped = np.diff(code >> 8, prepend=code[-1] >> 8) != 0
    assert (wrapped == (error != 0)).all()


@pytest.mark.parametrize("form", ["gyro_saturation_plateau", "accel_saturation_plateau"])
def test_a_plateau_behind_the_calibration_is_many_values_and_differs_by_side(
    pair: Callable[..., tuple[np.ndarray, ...]], form: str
) -> None:
    coupling = [[0.0, 0.01, 0.0], [0.0, 0.0, 0.01], [0.01, 0.0, 0.0]]
    limit = 2.0 if form.startswith("gyro") else 7.0
    channel = 0 if form.startswith("gyro") else 4
    offset = [0.05 * limit] * 3
    without, written = pair(form, strength=0.0, limit=limit, offset=offset, coupling=coupling)
    high = written[channel][without[channel] > 1.1 * limit]
    low = written[channel][without[channel] < -1.1 * limit]
    assert len(np.unique(high)) > 10
    assert np.ptp(high) < 0.03 * limit
    assert high.mean() == pytest.approx(0.95 * limit, rel=0.03)
    if channel == 0:
        assert low.mean() == pytest.approx(-1.05 * limit, rel=0.03)


def test_rows_are_held_doubled_or_interpolated(
    pair: Callable[..., tuple[np.ndarray, ...]],
) -> None:
    _, held = pair("repeated_samples_held", rate=0.5)
    assert (held[:, 1::2] == held[:, : 2 * held[:, 1::2].shape[1] : 2]).all()
    without, doubled = pair("repeated_samples_doubled", share=0.2)
    same = (doubled[:, 1:] == doubled[:, :-1]).all(axis=0)
    assert same.mean() == pytest.approx(0.2, abs=0.02)
    assert (doubled[:, 1:][:, ~same] == without[:, 1:][:, ~same]).all()
    without, lines = pair("repeated_samples_interpolated", every=4)
    assert (lines[:, ::4] == without[:, ::4]).all()
    assert lines[0, 2:-4:4] == pytest.approx(
        (lines[0, :-4:4] + lines[0, 4::4])[: len(lines[0, 2:-4:4])] / 2
    )


def test_stamps_scatter_or_close_up_in_batches() -> None:
    plain = played(rough_of("shaft")).recording.imu
    loose = played(rough_of("shaft", "timestamp_jitter", sigma=1e-3)).recording.imu
    assert (loose.t - plain.t).std() == pytest.approx(1e-3, rel=0.05)
    assert (loose.columns["gyro_x"] == plain.columns["gyro_x"]).all()
    batched = played(rough_of("shaft", "timestamp_jitter_batched", batch=5, squeeze=0.8))
    gaps = np.diff(batched.recording.imu.t)
    assert np.median(gaps) == pytest.approx(0.002)
    assert gaps.max() == pytest.approx(0.042, rel=0.01)
    assert (batched.recording.imu.t - plain.t).mean() == pytest.approx(0.0, abs=1e-4)


# How far an effect stands above all else counts its own signature alone.


@pytest.mark.parametrize("form", ["vibration_rectification", "vibration_rectification_speed"])
def test_shaking_is_what_rectification_stands_above_and_no_part_of_it(form: str) -> None:
    rough = rough_of("shaft", form)
    rest = play(without(rough, form))
    once, twice = (standing(play(rough.with_strength(form, k)), rest) for k in (1.0, 2.0))
    assert standing(play(rough.with_strength(form, 0.0)), rest) == 0.0
    assert 0.0 < once < standing(play(rough), play(rough.without(form)))
    assert 1.5 * once < twice < 2.5 * once  # codes round what is small
