"""Planted contributions on a run made by hand: their dimension, channel and segments."""

from dataclasses import replace

import numpy as np
import pytest

from schemas.discrepancy import HeldOut, Where
from schemas.recording import ACCEL, GYRO, Recording, Stream
from tasks.explain.explanation import Explanation, Finding
from tasks.explain.locate.where import locate, settling_time
from tasks.model.terms.memory import BIAS_RANDOM_WALK
from tasks.motion.whole import Motion, whole_motion
from tests.manifests import THREE_AXES, manifest_of

RATE_HZ = 20.0
NOISE = np.array([1e-4, 1e-4, 1e-4, 1e-3, 1e-3, 1e-3])
DWELL, MOVE, RAMP = 20.0, 4.0, 2.0
RATES = (-300.0, -100.0, -30.0, 30.0, 100.0, 300.0)
# Angles of the middle and inner axis that put +x, −x, +y, −y, +z, −z up.
UPRIGHT = {
    "+x": (90, 90), "-x": (90, -90), "+y": (90, 0), "-y": (-90, 0), "+z": (0, 0), "-z": (180, 0),
}  # fmt: skip


class Table:
    """Three angles by knots of time, and what each stretch is called."""

    def __init__(self) -> None:
        self.knots = [(0.0, 0.0, 0.0, 0.0)]
        self.segments: list[dict[str, object]] = []

    def go(
        self, seconds: float, outer: float, middle: float, inner: float, **label: object
    ) -> None:
        t = self.knots[-1][0]
        self.knots.append((t + seconds, outer, middle, inner))
        number = len(self.segments)
        named = {"name": f"move{number:03d}", "kind": "transition"} | label
        self.segments.append(named | {"t_start": t, "t_end": t + seconds})


@pytest.fixture(scope="module")
def run() -> Recording:
    """Two rounds of six attitudes, then turns about each axis at three rates and both signs."""
    table = Table()
    for repeat in range(2):
        for up, (middle, inner) in UPRIGHT.items():
            outer = 120.0 * repeat
            table.go(MOVE, outer, middle, inner)
            table.go(DWELL, outer, middle, inner, name=f"rest_{up}_{repeat}", kind="static", up=up)
    outer = 120.0
    for up in ("+x", "+y", "+z"):
        middle, inner = UPRIGHT[up]
        table.go(MOVE, outer, middle, inner)
        for rate in RATES:
            table.go(RAMP, outer := outer + rate * RAMP / 2, middle, inner)
            label = {"name": f"rate_{up[1]}_{rate:+.0f}", "kind": "rate", "axis": up[1]}
            turned = {"up": up, "rate_deg_s": rate}
            table.go(DWELL, outer := outer + rate * DWELL, middle, inner, **label, **turned)
            table.go(RAMP, outer := outer + rate * RAMP / 2, middle, inner)
    knots = np.array(table.knots)
    fine = np.arange(0.0, knots[-1, 0], 0.01)
    angles = np.radians([np.interp(fine, knots[:, 0], knots[:, k]) for k in (1, 2, 3)])
    t = np.round(np.arange(0.0, knots[-1, 0] - 0.1, 1 / RATE_HZ), 9)
    rng = np.random.default_rng(1)
    noise = NOISE[:, None] * rng.standard_normal((6, len(t)))
    columns = dict(zip(GYRO + ACCEL, noise, strict=True))
    columns["temperature"] = 25.0 + 5.0 * np.sin(t / 70.0)  # no other course goes up and down so
    manifest = manifest_of("hand-made", {"heading_deg": 0.0}, THREE_AXES, segments=table.segments)
    names = ("outer_angle", "middle_angle", "inner_angle")
    air = {"supply_voltage": 5.0 + 0.01 * np.cos(fine[::100] / 31.0)}
    return Recording(
        manifest, Stream(t, columns), Stream(fine, dict(zip(names, angles, strict=True))),
        environment=Stream(fine[::100], air),
    )  # fmt: skip


@pytest.fixture(scope="module")
def motion(run) -> Motion:
    return whole_motion(run)


def explained(recording: Recording, *contributions: np.ndarray) -> Explanation:
    """An explanation with these contributions, and readings that are what they add up to."""
    findings = tuple(
        Finding(
            "unnamed", "unnamed", ("", ""), "", "", tuple(range(6)), (), each, 100.0, 50.0, 40.0
        )
        for each in contributions
    )
    nominal = np.zeros((len(recording.imu), 6))
    held_out = HeldOut(rms_ratio={}, chi2_per_dof_before=2.0, chi2_per_dof_after=1.0)
    found = nominal + sum(contributions)
    return Explanation(recording, nominal, found, NOISE, 0.0, "explained", held_out, findings)


def in_channels(count: int, **courses: np.ndarray) -> np.ndarray:
    """(n, 6) with courses in the channels that are named."""
    every = GYRO + ACCEL
    return np.column_stack([courses.get(name, np.zeros(count)) for name in every])


def since_last_move(recording: Recording) -> np.ndarray:
    """Seconds since a move ended, by the labels; negative while one is under way."""
    t = recording.imu.t
    moves = [s for s in recording.manifest.segments or () if s.t_end - s.t_start == MOVE]
    since = np.full(len(t), 1e9)
    for move in moves:
        since = np.where(t >= move.t_start, t - move.t_end, since)
    return since


def one(where: tuple[Where, ...]) -> Where:
    assert where[0].share == pytest.approx(1.0)
    return where[0]


def test_of_what_nothing_explains_the_residual_is_located(run, motion):
    since = since_last_move(run)
    creep = np.where(since > 0, np.exp(-np.maximum(since, 0.0) / 4.0), 0.0)
    nothing = explained(run, np.zeros((len(since), 6)))
    rest = replace(nothing.findings[0], channels=(4,), remainder=True)
    left = replace(nothing, found=-in_channels(len(since), accel_y=0.02 * creep), findings=(rest,))
    (where,) = locate(left)
    assert (one(where).channel, one(where).dimension) == ("accel_y", "after_moves")


def test_what_fades_after_moves_is_found_after_moves_with_its_time_constant(run, motion):
    since = since_last_move(run)
    creep = np.where(since > 0, np.exp(-np.maximum(since, 0.0) / 4.0), 0.0)
    (where,) = locate(explained(run, in_channels(len(since), accel_y=0.02 * creep)))
    first = one(where)
    assert (first.channel, first.dimension) == ("accel_y", "after_moves")
    assert "5 s after moves" in first.description.en
    assert "time constant of 4 s" in first.description.en
    assert "时间常数 4 s" in first.description.zh


def test_what_is_seen_at_high_rate_only_is_found_there(run, motion):
    fast = np.abs(motion.rate[:, 0]) > np.radians(250.0)
    shape = np.where(fast, 1e-3, 0.0)
    (where,) = locate(explained(run, in_channels(len(shape), gyro_x=shape)))
    first = one(where)
    assert (first.channel, first.dimension) == ("gyro_x", "rate")
    assert set(first.segments) >= {"rate_x_+300", "rate_x_-300"}


def test_what_one_attitude_adds_is_found_at_that_attitude(run, motion):
    up = np.where(motion.up[:, 1] < -0.99, 2e-3, 0.0)
    (where,) = locate(explained(run, in_channels(len(up), gyro_z=up)))
    first = one(where)
    assert (first.channel, first.dimension) == ("gyro_z", "attitude")
    assert "-y" in first.description.en
    assert {"rest_-y_0", "rest_-y_1"} <= set(first.segments)


def test_rows_at_which_a_contribution_is_not_known_have_no_part_in_where_it_sits(run, motion):
    """As where turns have no reference: what differs from rest to rest does not follow the rate."""
    placed = 0.05 * (motion.up[:, 0] * motion.up[:, 0] - motion.up[:, 1] * motion.up[:, 1])
    placed[np.linalg.norm(motion.rate, axis=1) > np.radians(1.0)] = np.nan
    (where,) = locate(explained(run, in_channels(len(placed), accel_z=placed)))
    assert (one(where).channel, one(where).dimension) == ("accel_z", "attitude")


def test_a_drift_is_located_by_time_though_attitudes_follow_one_another_in_it(run, motion):
    up = np.where(motion.up[:, 1] < -0.99, 2e-3, 0.0)
    drift = explained(run, in_channels(len(up), gyro_z=up))
    (walk,) = drift.findings
    drift = replace(drift, findings=(replace(walk, terms=(BIAS_RANDOM_WALK.key,)),))
    ((first, *_),) = locate(drift)
    assert first.channel == "gyro_z"
    assert first.dimension not in ("attitude", "rate", "after_moves", "temperature", "recorded")


def test_waves_per_turn_are_counted(run, motion):
    assert motion.axes is not None
    angle, speed = motion.axes.angles[:, 0], motion.axes.speeds[:, 0]
    ripple = 1e-3 * np.cos(5 * angle + 0.3) * (np.abs(speed) > 0.1)
    (where,) = locate(explained(run, in_channels(len(ripple), gyro_y=ripple)))
    assert one(where).dimension == "rotation_phase"
    assert "5 cycles per revolution of the outer axis" in one(where).description.en


def test_what_goes_by_the_temperature_is_told_with_its_values(run):
    warm = 1e-4 * (run.imu.columns["temperature"] - 25.0)
    (where,) = locate(explained(run, in_channels(len(warm), gyro_x=warm, accel_x=10 * warm)))
    assert {each.channel for each in where} == {"gyro_x", "accel_x"}
    for each in where:
        assert each.dimension == "temperature"
        assert "follows the unit's temperature" in each.description.en
        assert "°C" in each.description.en


def test_a_jump_is_told_with_its_moment(run):
    t = run.imu.t
    moment = 0.55 * t[-1]
    (where,) = locate(explained(run, in_channels(len(t), gyro_x=1e-3 * (t > moment))))
    assert one(where).dimension == "time"
    assert f"{moment:.4g} s" in one(where).description.en


def test_a_line_is_told_with_its_frequency(run):
    hum = 1e-3 * np.sin(2 * np.pi * 6.2504 * run.imu.t)
    (where,) = locate(explained(run, in_channels(len(hum), accel_z=hum)))
    assert one(where).dimension == "frequency"
    assert "6.25" in one(where).description.en


def test_a_lever_arm_is_found_on_the_ramps_for_the_rest_is_taken_up(run, motion):
    arm = np.array([0.03, -0.02, 0.05])
    centripetal = np.cross(motion.rate, np.cross(motion.rate, arm))
    felt = np.cross(motion.acceleration, arm) + centripetal
    whole = np.hstack([np.zeros_like(felt), felt])
    (where,) = locate(explained(run, np.nan_to_num(whole)))
    assert {each.dimension for each in where} == {"ramps"}


def test_what_is_spread_evenly_is_level(run):
    even = 1e-3 * np.random.default_rng(3).choice([-1.0, 1.0], len(run.imu))
    (where,) = locate(explained(run, in_channels(len(even), gyro_x=even)))
    assert one(where).dimension == "level"


def test_shares_add_up_to_one_by_falling_share_with_the_slight_channels_last(run, motion):
    cubic = motion.rate**3
    x, y, z = (1e-4 * cubic).T
    gyro = in_channels(len(cubic), gyro_x=x, gyro_y=3 * y, gyro_z=0.2 * z)
    (where,) = locate(explained(run, gyro))
    assert [each.channel for each in where] == ["gyro_y", "gyro_x", "gyro_z"]
    assert sum(each.share for each in where) == pytest.approx(1.0)
    assert where[0].share > where[1].share
    assert where[-1].dimension == "level"


def test_each_finding_has_its_own_place(run, motion):
    warm = 1e-4 * (run.imu.columns["temperature"] - 25.0)
    cubic = 1e-4 * motion.rate[:, 2] ** 3
    count = len(warm)
    both = explained(run, in_channels(count, accel_x=warm), in_channels(count, gyro_z=cubic))
    assert [one(each).dimension for each in locate(both)] == ["temperature", "rate"]


def test_what_the_standard_takes_up_whole_is_said_to_be_nowhere(run, motion):
    (where,) = locate(explained(run, in_channels(len(motion.t))))
    assert one(where).dimension == "level"
    assert "fully absorbed" in one(where).description.en


def test_no_finding_has_no_place(run):
    assert locate(explained(run)) == ()


def test_what_does_not_fade_has_no_time_constant(run, motion):
    assert settling_time(motion, np.random.default_rng(4).standard_normal(len(motion.t))) is None
