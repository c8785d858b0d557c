"""Lines and bursts are detected in what a regression leaves, and nothing in noise."""

from dataclasses import replace

import numpy as np
import pytest

from tasks.explain.events.bursts import Ringing
from tasks.explain.events.detect import events_in_readings, events_in_residual
from tasks.explain.events.event import Event, Events
from tasks.explain.events.lines import mains_of
from tasks.motion.pose import Tracking
from tasks.motion.table import TableAxes
from tasks.motion.whole import Motion
from tasks.words import say, texts
from tests.tasks.explain.events.made_up import RATE, SIGMA, motion, noisy


def _detected(made: Motion, left: np.ndarray) -> Events:
    none = Events((), np.zeros(left.shape, bool))
    events = events_in_residual(none, left, SIGMA, made)
    assert all(all(texts(event.description).values()) for event in events.events)
    return events


def _noise(made: Motion, seed: int) -> np.ndarray:
    return noisy(np.zeros((len(made.t), 6)), seed)


def _value(event: Event, name: str) -> float:
    return next(each.value for each in event.parameters if each.name == name)


def _on_table(made: Motion) -> Motion:
    """The same run, with all its turns made one way by the outer axis of a table."""
    speed = np.abs(made.rate).max(axis=1)[:, None]
    angle = np.cumsum(speed, axis=0) / RATE
    directions = np.tile(np.eye(3)[:1], (len(made.t), 1, 1))
    return replace(made, axes=TableAxes(angle, speed, directions, made.up))


def _rung(
    made: Motion, starts: np.ndarray, wave: np.ndarray, hertz: float, decay: float
) -> np.ndarray:
    gain = np.where(wave != 0, 100.0, 0.0)
    return Ringing(np.sort(starts), wave, gain, hertz, decay).signal(made.t)


@pytest.mark.parametrize("seed", range(3))
def test_nothing_is_detected_in_noise(seed):
    made = _on_table(motion())
    assert _detected(made, _noise(made, seed)).events == ()


def test_mains_and_its_alias_are_named_and_other_lines_are_not():
    made = motion(minutes=4.0)
    for frequency, effect in ((60.03, "mains_pickup"), (17.3, "unnamed")):
        wave = np.cos(2 * np.pi * frequency * made.t + 1.0)
        left = _noise(made, 10)
        left[:, 1] += 1e-4 * wave
        left[:, 4] += 3e-4 * wave
        events = _detected(made, left)
        (event,) = events.events
        assert event.effect == effect
        assert ("39.970 Hz" in say(event.title, "en")) == (effect == "mains_pickup")
        assert _value(event, "frequency") == pytest.approx(frequency, abs=4e-4)
        assert _value(event, "gyro_y") == pytest.approx(1e-4, abs=3e-5)
        added = events.applied(made.t, np.zeros((len(made.t), 6)))
        assert np.corrcoef(added[:, 1], wave)[0, 1] > 0.95


@pytest.mark.parametrize(  # waves: of the beat with half the sample rate
    ("waves", "phase"), [(1.2, 0.0), (1.2, 1.6), (1.7, 0.8), (3.4, 0.0), (3.4, 1.6)]
)
def test_mains_at_nearly_half_the_sample_rate_have_their_amplitude(waves, phase):
    made = motion(minutes=4.0)
    frequency = 0.5 * RATE - waves / made.t[-1]
    left = _noise(made, 31)
    left[:, 1] += 1e-4 * np.cos(2 * np.pi * frequency * made.t + phase)
    (event,) = _detected(made, left).events
    assert event.effect == "mains_pickup"
    assert _value(event, "gyro_y") == pytest.approx(1e-4, rel=0.2)


def test_of_a_body_with_tracked_poses_the_mains_alone_are_a_line():
    tracked = replace(motion(), tracking=Tracking(8.0, 8.0, 0.01, 1e-8, 1e-8))
    for frequency, effects in ((49.97, ["mains_pickup"]), (17.3, [])):
        left = _noise(tracked, 10)
        left[:, 4] += 1e-3 * np.cos(2 * np.pi * frequency * tracked.t)
        assert [event.effect for event in _detected(tracked, left).events] == effects


def test_a_channel_that_reads_one_value_throughout_is_not_used_and_it_is_said():
    made = motion()
    readings = noisy(np.hstack([made.rate, made.force]), 5)
    readings[:, 1] = 0.0
    events = events_in_readings(readings, made)
    assert events.masked.all(axis=0).tolist() == [False, True, False, False, False, False]
    (constant,) = [each for each in events.remarks if each.id == "events-constant"]
    assert "gyro y read one value throughout" in say(constant, "en")
    assert "陀螺 y" in say(constant, "zh").replace("陀螺y", "陀螺 y")


def test_harmonic_is_the_mains_only_beside_its_fundamental():
    made = motion()
    left = _noise(made, 22)
    left[:, 4] += 1e-3 * np.cos(2 * np.pi * 2 * 60.01 * made.t)
    assert [event.effect for event in _detected(made, left).events] == ["unnamed"]
    left[:, 4] += 1e-3 * np.cos(2 * np.pi * 60.01 * made.t)
    (event,) = _detected(made, left).events
    assert event.effect == "mains_pickup"
    assert _value(event, "accel_y_2") == pytest.approx(1e-3, rel=0.2)


def test_line_that_is_there_only_while_the_table_turns_is_not_a_line():
    made = motion()
    turns = np.abs(made.rate).max(axis=1) > 1
    left = _noise(made, 11)
    left[:, 3] += 1e-3 * np.cos(2 * np.pi * 7.7 * made.t) * turns
    assert _detected(made, left).events == ()


def test_a_line_below_half_the_mean_rate_is_found_though_most_steps_are_longer():
    """Stamps of which a few steps are shorter: half the rate of the usual step lies lower."""
    made = motion()
    steps = np.full(len(made.t), 1.001 / RATE)
    steps[::4] -= steps.mean() * 4 - 4 / RATE  # as many rows in a second as ever
    stamped = replace(made, t=np.cumsum(steps) - steps[0])
    left = _noise(made, 15)
    hertz = 0.5 / steps.mean() - 1.5 / stamped.t[-1]
    left[:, 1] += 1e-3 * np.cos(2 * np.pi * hertz * stamped.t)
    (line,) = _detected(stamped, left).lines
    assert line == pytest.approx(hertz, abs=1.0 / stamped.t[-1])


def test_mains_on_either_side_of_a_fold_cannot_be_told_apart():
    harmonic, sources = mains_of(49.92, RATE) or (0, ())
    assert harmonic == 1
    assert sources == pytest.approx((49.92, 50.08))
    assert mains_of(31.0, RATE) is None


def test_line_before_lost_samples_goes_on_after_them():
    made = motion(minutes=6.0)
    taken = np.delete(np.arange(len(made.t)), [12_710])
    wave = 1e-3 * np.cos(2 * np.pi * 17.3 * made.t)
    mean = np.hstack([made.rate, made.up * 9.8])
    readings = noisy(mean, 23)
    readings[:, 4] += wave
    t = made.t[: len(taken)]
    observed = made.taken(np.arange(len(taken)))
    events = events_in_readings(readings[taken], observed)
    left = readings[taken] - events.applied(t, mean[: len(t)])
    found = events_in_residual(events, left, SIGMA, observed)
    assert [event.effect for event in found.events] == ["unnamed", "dropped_samples"]
    added = found.applied(t, mean[: len(t)]) - mean[taken]
    assert added[:-1, 4] == pytest.approx(wave[taken][:-1], abs=2e-4)


def test_bursts_are_counted_and_taken_away_by_what_they_have_in_common():
    made = motion(minutes=10.0)
    even = np.array([53.0, 112.2, 193.4, 213.9, 373.3, 454.6])
    wave = np.array([0, 4e-3, 2e-3j, 0, 0, 0])
    bursts = _rung(made, even, wave, 2.3, 1.1)
    (event,) = _detected(made, _noise(made, 25) + bursts).events
    assert event.effect == "unnamed"
    assert event.channels == (1, 2)
    assert _value(event, "bursts") == len(even)
    assert _value(event, "frequency") == pytest.approx(2.3, abs=0.05)
    assert _value(event, "decay") == pytest.approx(1.1, rel=0.3)
    added = event.applied(made.t, np.zeros((len(made.t), 6)))
    assert ((added - bursts) ** 2).sum() < 0.2 * (bursts**2).sum()


def test_what_swings_after_every_move_is_no_burst():
    made = motion(minutes=10.0)
    moves = np.arange(8.0, 590.0, 20.0)
    left = _noise(made, 26) + _rung(made, moves, np.array([0, 3e-3, 0, 0, 0, 0j]), 2.3, 1.1)
    assert _detected(made, left).events == ()


def test_step_is_no_burst():
    made = motion(minutes=4.0)
    left = _noise(made, 27)
    left[made.t > 133.0, 4] += 0.02
    assert _detected(made, left).events == ()


def test_short_absent_or_dead_channels_are_no_events():
    made = _on_table(motion())
    left = _noise(made, 28)
    left[:, 3:] = np.nan
    left[:, 2] = 1e-15 * np.sin(made.t)
    assert _detected(made, left).events == ()
    few = made.taken(np.arange(50))
    assert _detected(few, left[:50]).events == ()


# A line that dominates a plain fit's residual goes before a search; the motion's own stay.

RATE_DOMINANT_LINES, PERIOD = 100.0, 1.107  # Hz; s of one turn there and back
DELAY, HUM = 0.012, 9.5945  # s, Hz
SIGMA_DOMINANT_LINES = np.array([1e-3] * 3 + [5e-3] * 3)


def _speed(t: np.ndarray) -> np.ndarray:
    """rad/s of a shaft that turns to and fro."""
    return 5.6 * np.tanh(12.0 * np.sin(2 * np.pi * t / PERIOD))


def _motion(t: np.ndarray) -> Motion:
    rate = np.zeros((len(t), 3))
    rate[:, 2] = _speed(t)
    up = np.tile([0.0, 0.0, 1.0], (len(t), 1))
    return Motion(t, up, np.zeros_like(rate), rate, np.gradient(rate, t, axis=0), 9.8)


def _readings(t: np.ndarray, hum: float) -> np.ndarray:
    """Of a unit whose clock is late, on a rig that hums at HUM with an amplitude in rad/s."""
    readings = SIGMA_DOMINANT_LINES * np.random.default_rng(3).standard_normal((len(t), 6))
    readings[:, 2] += _speed(t - DELAY) + hum * np.cos(2 * np.pi * HUM * t + 0.4)
    readings[:, 5] += 9.8
    return readings


@pytest.mark.parametrize("jitter", [0.0, 4e-3])
def test_a_hum_that_dominates_is_found_beside_the_lines_of_a_late_clock(jitter):
    t = np.arange(12_000) / RATE_DOMINANT_LINES
    t += jitter * (np.random.default_rng(8).random(len(t)) - 0.5)
    t = np.round(t, 3)  # s, as a logger writes it
    events = events_in_readings(_readings(t, 2.3), _motion(t))
    assert events.lines == pytest.approx((HUM,), abs=1e-4)
    (line,) = [each for each in events.events if each.effect == "unnamed"]
    sizes = {each.name: each.value for each in line.parameters}
    assert sizes["gyro_z"] == pytest.approx(2.3, rel=0.01)


def test_what_a_late_clock_leaves_of_a_periodic_motion_is_no_line():
    t = np.arange(12_000) / RATE_DOMINANT_LINES
    assert events_in_readings(_readings(t, 0.0), _motion(t)).lines == ()


def test_what_a_lever_arm_makes_of_a_periodic_motion_is_no_line():
    t = np.arange(12_000) / RATE_DOMINANT_LINES
    motion, readings = _motion(t), _readings(t, 0.0)
    readings[:, 3] -= 0.08 * motion.rate[:, 2] ** 2
    readings[:, 4] += 0.08 * motion.acceleration[:, 2]
    assert events_in_readings(readings, motion).lines == ()


def test_poses_do_not_show_how_a_body_hums():
    t = np.arange(12_000) / RATE_DOMINANT_LINES
    tracked = replace(_motion(t), tracking=Tracking(8.0, 8.0, 0.01, 1e-8, 1e-8))
    assert events_in_readings(_readings(t, 2.3), tracked).lines == ()


def test_a_line_removed_before_is_found_again_beside_the_fit():
    t = np.arange(12_000) / RATE_DOMINANT_LINES
    motion, readings = _motion(t), _readings(t, 2.3)
    late = np.column_stack([0 * t, 0 * t, _speed(t - DELAY)])
    predicted = np.hstack([late, 9.8 * motion.up])
    others = events_in_readings(readings, motion).without_added()
    after = events_in_residual(
        others, readings - others.applied(t, predicted), SIGMA_DOMINANT_LINES, motion
    )
    assert others.lines == ()
    assert len(after.lines) == 1
    rest = readings - after.applied(t, predicted)
    assert rest[:, 2].std() < 1.1 * SIGMA_DOMINANT_LINES[2]
