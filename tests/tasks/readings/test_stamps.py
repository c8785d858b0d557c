"""Stamps of packets are put at even instants, whatever their size; other stamps stay."""

from dataclasses import replace

import numpy as np
import pytest
from logged import Unit, procedure, read, recorded, swinging
from logged import in_packets as sent

from tasks.readings.stamps import in_packets, with_instants

# Hz, s between the host's questions, samples that the unit collects
PACKETS = [
    (200.0, 0.0158, None), (100.0, 0.016, None), (100.0, 0.012, None), (400.0, 0.02, None),
    (1000.0, 0.016, None), (833.0, 0.1, None), (200.0, None, 5), (104.0, None, 2),
    (50.0, None, 50), (125.0, None, 200), (100.0, None, (2, 9)), (25.0, None, (1, 4)),
]  # fmt: skip


@pytest.mark.parametrize(("rate", "period", "size"), PACKETS)
@pytest.mark.parametrize("lost", [0, 1, 4])
def test_instants_of_packets_are_even_and_losses_counted(rate, period, size, lost):
    rng = np.random.default_rng(round(rate) + lost)
    at = 0.1 + np.arange(0.0, 400.0, 1.0 / rate)
    kept = np.ones(len(at), bool)
    for where in (111.0, 222.0) if lost else ():
        kept[(first := int(where * rate)) : first + lost] = False
    taken = at[kept]
    stamps = sent(taken, period, size or 1, rng)
    found = in_packets(stamps)
    assert found is not None
    assert found.interval * rate == pytest.approx(1.0, abs=1e-5 if not lost else 4e-5)
    few = size is not None and np.max(size) >= 50  # packets: those that lack one are not all seen
    assert found.missing[:, 1].tolist() in ([lost, lost] if lost else [], [] if few else None)
    off = found.t - taken
    assert off.mean() == pytest.approx((stamps - taken).mean(), abs=1e-5)
    assert np.std(off) < (0.25 if not lost else 0.5 if not few else 3.0) / rate


def _even(rng: np.random.Generator, rate: float) -> np.ndarray:
    return np.arange(20_000) / rate


def _jittered(rng: np.random.Generator, rate: float) -> np.ndarray:
    return _even(rng, rate) + rng.normal(0.0, 0.15 / rate, 20_000).clip(-0.4 / rate, 0.4 / rate)


def _rounded(rng: np.random.Generator, rate: float) -> np.ndarray:
    return np.round(_even(rng, rate) * 1.00037, 3)


def _with_gaps(rng: np.random.Generator, rate: float) -> np.ndarray:
    return _even(rng, rate)[rng.uniform(size=20_000) > 0.03]


def _drifting(rng: np.random.Generator, rate: float) -> np.ndarray:
    t = _even(rng, rate)
    return t + 1e-3 * np.sin(t / 30.0)


@pytest.mark.parametrize("stamped", [_even, _jittered, _rounded, _with_gaps, _drifting])
@pytest.mark.parametrize("rate", [5.0, 50.0, 200.0])
def test_other_stamps_are_left_alone(stamped, rate):
    assert in_packets(stamped(np.random.default_rng(7), rate)) is None


@pytest.mark.parametrize(
    ("rate", "run", "pause"),
    [
        (100.0, 30.0, 30.0),
        (10.0, 10.0, 60.0),
        (1.0, 30.0, 30.0),
        (200.0, 5.0, 5.0),
        (50.0, 2.0, 5.0),
    ],
)
@pytest.mark.parametrize("loose", [0.0, 0.1])
def test_pauses_are_no_packets(rate, run, pause, loose):
    rng = np.random.default_rng(round(run))
    starts = np.cumsum((run + pause) * (1.0 + loose * rng.uniform(-1.0, 1.0, 30)))
    stamps = (starts[:, None] + np.arange(0.0, run, 1.0 / rate)).ravel()
    assert in_packets(stamps) is None


def test_what_was_put_right_is_said_and_done_once():
    course, rng = procedure(rest=4.0, hold=4.0), np.random.default_rng(3)
    at = np.arange(0.0, course.until, 0.01)
    recording = recorded("sent", course, sent(at, 0.025, 1, rng), read(course, at, Unit(), rng))
    right = with_instants(recording)
    assert np.ptp(right.imu.t - at) < 1e-3
    (remark,) = right.put_right
    assert "packets" in remark.en
    assert "100 Hz" in remark.en
    assert with_instants(right) is right


def test_bursts_that_were_sampled_as_they_are_stamped_stay():
    course, rng = swinging(120.0), np.random.default_rng(4)
    at = (np.arange(0.0, course.until, 0.1)[:, None] + 0.002 * np.arange(4)).ravel()
    recording = recorded("bursts", course, at, read(course, at, Unit(), rng))
    assert in_packets(at) is not None
    assert with_instants(recording) is recording


def test_equal_stamps_of_a_packet_are_one_arrival():
    at = np.arange(0.0, 100.0, 0.01)
    stamps = np.ceil(at / 0.04) * 0.04
    found = in_packets(stamps)
    assert found is not None
    assert np.ptp(found.t - at) < 2.5e-3
    assert (np.diff(found.t) > 0.0).all()
    assert replace(found).size == pytest.approx(4.0, abs=0.01)
