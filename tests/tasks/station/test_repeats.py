"""Segments that wait for the operator, and those that are measured again."""

from unittest.mock import patch

import numpy as np
import pytest

from tasks.station import recorder as recorder_module
from tasks.station.acquisition import Acquired, NewRecording, RunRequest
from tasks.station.progress import Progress
from tasks.station.sequencer import REPEATS
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import StationFault
from tests.tasks.station.in_memory import InMemoryStation
from tests.tasks.station.over_sockets import MEASURED, ignore


def repeats(acquired: Acquired) -> list[str]:
    return [each.en for each in acquired.warnings if each.code == "segment_repeated"]


def test_a_pause_rests_before_the_next_segment_and_the_run_goes_on_as_one(short, kept):
    station = InMemoryStation(VirtualStation())
    rates = []

    def until_a_minute_has_passed() -> bool:
        resting = bool(kept.manifests) and len(kept.measured()) == 3
        if resting:
            rates.append(station.simulation.table.rate[0])
        return resting and station.simulation.table.now < 120.0

    recording = NewRecording(station.file, kept, "paused")
    request = RunRequest(
        station.file, short, (recording,), ignore, is_paused=until_a_minute_has_passed
    )
    station.run(request)
    assert rates[-1] == pytest.approx(0.0, abs=1e-6)
    assert kept.measured() == MEASURED
    assert any(s.name.startswith("pause") for s in kept.manifests[-1].segments)
    assert np.diff(kept.stream("imu").t) == pytest.approx(0.01, abs=1e-9)


def test_a_segment_that_a_moment_spoiled_is_measured_again_and_said_so(short, kept):
    station = InMemoryStation(VirtualStation())
    begun: list[str] = []

    def spoil_once(progress: Progress) -> None:
        begun.append(progress.now)
        first = progress.now == "rate x -50 deg/s" and "rate x +100 deg/s" not in begun
        station.simulation.faults = (StationFault("unit_drops"),) if first else ()

    acquired = station.acquire(short, kept, spoil_once)
    assert sorted(kept.measured()) == sorted(MEASURED)
    assert kept.measured()[-1] == "rate_x_-50"
    assert ["rate_x_-50" in sentence for sentence in repeats(acquired)] == [True]
    lost = next(each for each in acquired.warnings if each.code == "unit_lost_samples")
    assert lost.segments == ()
    again = kept.manifests[-1].segments[-1]
    rows = kept.stream("imu").rows(again.t_start, again.t_end)
    assert np.diff(kept.stream("imu").t[rows]) == pytest.approx(0.01, abs=1e-9)


@pytest.mark.rehearsal
def test_a_segment_that_stays_bad_is_repeated_twice_and_then_kept_with_its_remark(short, kept):
    station = InMemoryStation(VirtualStation(), faults=[StationFault("stuck_channel")])
    acquired = station.acquire(short, kept)
    assert sorted(kept.measured()) == sorted(MEASURED)
    withdrawn = [s for s in kept.manifests[-1].segments if s.name.startswith("withdrawn")]
    assert len(withdrawn) == REPEATS * len(MEASURED)
    stuck = next(each for each in acquired.warnings if each.code == "stuck_channel")
    assert set(stuck.segments) == set(MEASURED)


def test_where_everything_is_bad_nothing_is_repeated(short, kept):
    station = InMemoryStation(VirtualStation(), faults=[StationFault("stuck_channel")])
    with patch.object(recorder_module, "MOST_REPEATED", 3):
        acquired = station.acquire(short, kept)
    assert repeats(acquired) == []
    assert kept.measured() == MEASURED
