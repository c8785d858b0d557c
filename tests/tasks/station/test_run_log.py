"""What a run leaves in its log, and what who watches it sees meanwhile."""

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.recording import Stream
from schemas.run_log import LogEntry
from tasks.station.unit_recorder import ROWS, LastRows
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import StationFault
from tests.tasks.station.in_memory import InMemoryStation
from tests.tasks.station.over_sockets import MEASURED


def log_of(kept) -> list[LogEntry]:
    return [LogEntry.model_validate(each) for each in kept.manifests[-1].model_extra["log"]]


def test_every_state_of_a_run_is_kept_with_its_time_and_cause(short, kept):
    InMemoryStation(VirtualStation()).acquire(short, kept)
    log = log_of(kept)
    assert [entry.state for entry in log] == [
        "begun", "warming_up", *["measuring"] * len(MEASURED), "finishing", "done",
    ]  # fmt: skip
    assert [entry.t for entry in log] == sorted(entry.t for entry in log)
    segments = kept.manifests[-1].segments
    measured = [segment for segment in segments if segment.name in MEASURED]
    for entry, segment in zip(log[2:6], measured, strict=True):
        assert entry.t <= segment.t_start
    assert log[4].en == "rate x -50 deg/s, segment 3 of 4."
    assert "第 3 段" in log[4].zh


def test_a_stop_is_kept_with_its_cause(short, kept):
    station = InMemoryStation(VirtualStation(), faults=[StationFault("emergency_stop", 15.0)])
    with pytest.raises(Unusable):
        station.acquire(short, kept)
    last = log_of(kept)[-1]
    assert last.state == "stopped"
    assert "emergency_stop" in last.en


def test_an_alarm_is_kept_once_and_counted_for_who_watches(short, kept):
    found = []
    station = InMemoryStation(VirtualStation(), faults=[StationFault("unit_drops")])
    station.acquire(short, kept, found.append)
    noticed = [entry.en for entry in log_of(kept) if entry.en.startswith("Alarm")]
    assert noticed == ["Alarm: lost samples from the unit."]
    (alarm,) = found[-1].alarms
    assert alarm.en.startswith("lost samples from the unit (")
    repeating = [entry for entry in log_of(kept) if entry.state == "repeating"]
    assert len(repeating) == found[-1].segments - len(MEASURED)


def test_who_watches_sees_state_segment_rates_and_noise(short, kept):
    found = []
    InMemoryStation(VirtualStation()).acquire(short, kept, found.append)
    at_rate = [each for each in found if each.now == "rate x +100 deg/s"]
    assert {(each.state, each.segment, each.segments) for each in at_rate} == {("measuring", 4, 4)}
    last = found[-1]
    assert (last.state, last.wall_s_left) == ("done", 0.0)
    assert last.rates_hz["imu"] == pytest.approx(100.0, rel=0.01)
    assert last.rates_hz["table"] == pytest.approx(100.0, rel=0.01)
    assert 0 < last.noise["gyro"] < 1.0
    assert 0 < last.noise["accel"] < 0.1


def test_noise_is_that_of_single_samples_and_motion_is_none_of_it():
    rows, t = LastRows(), np.arange(ROWS) / 100.0
    noise = np.random.default_rng(1).normal(0.0, 1e-3, ROWS)
    still = {name: np.zeros(ROWS) for name in ("gyro_y", "gyro_z")}
    rows.add("imu", Stream(t, {"gyro_x": 3.0 * t + noise, **still}))
    assert rows.noise == {"gyro": pytest.approx(np.degrees(1e-3), rel=0.1)}
    assert rows.rates_hz == {"imu": pytest.approx(100.0)}
