"""Lines, impacts and bursts are detected in what a regression leaves, and nothing in noise."""

from dataclasses import replace

import numpy as np
import pytest
from made_up import RATE, SIGMA, motion, noisy

from tasks.explain.events.detect import events_in_readings, events_in_residual
from tasks.explain.events.event import Event, Events
from tasks.explain.events.lines import mains_of
from tasks.explain.events.ringing import Ringing
from tasks.motion.pose import Tracking
from tasks.motion.table import TableAxes
from tasks.motion.whole import Motion
from tasks.words import say, texts


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
def test_nothing_is_detected_in_noise(seed: int) -> None:
    made = _on_table(motion())
    assert _detected(made, _noise(made, seed)).events == ()


def test_mains_and_its_alias_are_named_and_other_lines_are_not() -> None:
    made = motion(minutes=6.0)
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
def test_mains_at_nearly_half_the_sample_rate_have_their_amplitude(
    waves: float, phase: float
) -> None:
    made = motion(minutes=6.0)
    frequency = 0.5 * RATE - waves / made.t[-1]
    left = _noise(made, 31)
    left[:, 1] += 1e-4 * np.cos(2 * np.pi * frequency * made.t + phase)
    (event,) = _detected(made, left).events
    assert event.effect == "mains_pickup"
    assert _value(event, "gyro_y") == pytest.approx(1e-4, rel=0.2)


def test_of_a_body_with_tracked_poses_the_mains_alone_are_a_line() -> None:
    tracked = replace(motion(), tracking=Tracking(8.0, 8.0, 0.01, 1e-8, 1e-8))
    for frequency, effects in ((49.97, ["mains_pickup"]), (17.3, [])):
        left = _noise(tracked, 10)
        left[:, 4] += 1e-3 * np.cos(2 * np.pi * frequency * tracked.t)
        assert [event.effect for event in _detected(tracked, left).events] == effects


def test_a_channel_that_reads_one_value_throughout_is_not_used_and_it_is_said() -> None:
    made = motion()
    readings = noisy(np.hstack([made.rate, made.force]), 5)
    readings[:, 1] = 0.0
    events = events_in_readings(readings, made)
    assert events.masked.all(axis=0).tolist() == [False, True, False, False, False, False]
    (constant,) = [each for each in events.remarks if each.id == "events-constant"]
    assert "gyro y read one value throughout" in say(constant, "en")
    assert "陀螺 y" in say(constant, "zh").replace("陀螺y", "陀螺 y")


def test_harmonic_is_the_mains_only_beside_its_fundamental() -> None:
    made = motion()
    left = _noise(made, 22)
    left[:, 4] += 1e-3 * np.cos(2 * np.pi * 2 * 60.01 * made.t)
    assert [event.effect for event in _detected(made, left).events] == ["unnamed"]
    left[:, 4] += 1e-3 * np.cos(2 * np.pi * 60.01 * made.t)
    (event,) = _detected(made, left).events
    assert event.effect == "mains_pickup"
    assert _value(event, "accel_y_2") == pytest.approx(1e-3, rel=0.2)


def test_line_that_is_there_only_while_the_table_turns_is_not_a_line() -> None:
    made = motion()
    turns = np.abs(made.rate).max(axis=1) > 1
    left = _noise(made, 11)
    left[:, 3] += 1e-3 * np.cos(2 * np.pi * 7.7 * made.t) * turns
    assert _detected(made, left).events == ()


def test_a_line_below_half_the_mean_rate_is_found_though_most_steps_are_longer() -> None:
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


def test_mains_on_either_side_of_a_fold_cannot_be_told_apart() -> None:
    harmonic, sources = mains_of(49.92, RATE) or (0, ())
    assert harmonic == 1
    assert sources == pytest.approx((49.92, 50.08))
    assert mains_of(31.0, RATE) is None


def test_line_before_lost_samples_goes_on_after_them() -> None:
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


def test_clicks_that_follow_the_angle_are_counted_a_turn_and_taken_away() -> None:
    made = _on_table(motion(minutes=10.0))
    assert made.axes is not None
    turns = made.axes.angles[:, 0] / (2 * np.pi)
    number = np.floor(turns * 6.37 - 0.2)
    starts = made.t[1:][np.diff(number) != 0] - 0.5 / RATE
    wave = np.array([0, 0, 0, 0, 8e-3 - 4e-3j, 0])
    clicks = _rung(made, starts, wave, 23.0, 0.012)
    (event,) = _detected(made, _noise(made, 24) + clicks).events
    assert event.effect == "unnamed"
    assert event.channels == (4,)
    assert _value(event, "per_turn") == pytest.approx(6.37, abs=0.01)
    added = event.applied(made.t, np.zeros((len(made.t), 6)))
    assert ((added - clicks) ** 2).sum() < 0.3 * (clicks**2).sum()


def test_bursts_are_counted_and_taken_away_by_what_they_have_in_common() -> None:
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


def test_what_swings_after_every_move_is_no_burst() -> None:
    made = motion(minutes=10.0)
    moves = np.arange(8.0, 590.0, 20.0)
    left = _noise(made, 26) + _rung(made, moves, np.array([0, 3e-3, 0, 0, 0, 0j]), 2.3, 1.1)
    assert _detected(made, left).events == ()


def test_step_is_no_burst() -> None:
    made = motion(minutes=6.0)
    left = _noise(made, 27)
    left[made.t > 133.0, 4] += 0.02
    assert _detected(made, left).events == ()


def test_short_absent_or_dead_channels_are_no_events() -> None:
    made = _on_table(motion())
    left = _noise(made, 28)
    left[:, 3:] = np.nan
    left[:, 2] = 1e-15 * np.sin(made.t)
    assert _detected(made, left).events == ()
    few = made.taken(np.arange(50))
    assert _detected(few, left[:50]).events == ()
