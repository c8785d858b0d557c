"""What a run leaves in its log, and what who watches it sees meanwhile."""

from typing import Any

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.recording import LogEntry, Stream
from schemas.station import StationFile
from tasks.station.acquisition import Acquired, NewRecording, Progress, RunRequest, acquire
from tasks.station.recorder import ROWS, LastRows
from tasks.station.virtual.config import VirtualStation, draw_unit
from tasks.station.virtual.faults import StationFault
from tests.tasks.station.in_memory import InMemoryStation, spoils_once
from tests.tasks.station.over_sockets import MEASURED, SPEED, ignore, serving

# Several units on one table: one run, a recording of each.

TWO = VirtualStation(unit=draw_unit(1), neighbours=(draw_unit(2),))


def request(station: StationFile, procedure, sinks, report=ignore) -> RunRequest:
    recordings = tuple(
        NewRecording(alone, sink, alone.unit.serial)
        for alone, sink in zip(station.per_unit(), sinks, strict=True)
    )
    return RunRequest(station, procedure, recordings, report)


@pytest.fixture
def sinks(new_sink):
    return new_sink(), new_sink()


def run(procedure, sinks, faults=(), report=ignore) -> tuple[Acquired, ...]:
    station = InMemoryStation(TWO, faults=faults)
    return station.run(request(station.file, procedure, sinks, report))


def assert_whole(sink) -> None:
    assert sink.measured() == MEASURED
    for name in ("imu", "table"):
        assert np.diff(sink.stream(name).t) == pytest.approx(0.01, abs=1e-9)


def test_each_unit_has_a_recording_of_its_own_with_the_tables_data_in_it(short, sinks):
    first, second = run(short, sinks)
    for sink, acquired in zip(sinks, (first, second), strict=True):
        assert_whole(sink)
        assert (acquired.warnings, acquired.given_up) == ((), None)
    assert [each.manifest.unit.serial for each in (first, second)] == ["V00001", "V00002"]
    assert first.manifest.segments == second.manifest.segments
    one, other = (sink.stream("table") for sink in sinks)
    assert np.array_equal(one.t, other.t)
    assert np.array_equal(one.columns["inner_angle"], other.columns["inner_angle"])
    for sink, unit in zip(sinks, (TWO.unit, *TWO.neighbours), strict=True):
        rest = sink.stream("imu").columns["gyro_y"][:200].mean()
        assert rest == pytest.approx(unit.gyro.bias[1], abs=2e-4)


@pytest.fixture(scope="module")
def one_silent(short, new_sink):
    """A run in which the first unit falls silent: what was acquired, sinks, progress."""
    sinks, found = (new_sink(), new_sink()), []
    acquired = run(short, sinks, [StationFault("unit_silent", 8.0)], found.append)
    return acquired, sinks, found


def test_a_unit_that_falls_silent_is_given_up_and_its_neighbour_measured_to_the_end(one_silent):
    (first, second), sinks, _ = one_silent
    assert "has sent nothing for 3 s" in first.given_up
    assert second.given_up is None
    assert second.warnings == ()
    assert_whole(sinks[1])
    assert 0 < sinks[0].stream("imu").t[-1] < 9.0
    causes = [entry["en"] for entry in sinks[0].manifests[-1].model_extra["log"]]
    assert "The unit was abandoned" in causes[-1]


def test_when_every_unit_is_silent_the_run_stops(short, sinks):
    with pytest.raises(Unusable, match=r"the run stopped during .* has sent nothing"):
        run(short, sinks, [StationFault("supply_cut", 8.0)])


def test_a_segment_is_repeated_for_the_unit_that_needs_it_alone(short, sinks):
    station = InMemoryStation(TWO)
    first, second = station.run(request(station.file, short, sinks, spoils_once(station)))
    assert "segment_repeated" in {remark.code for remark in first.warnings}
    assert second.warnings == ()
    assert_whole(sinks[1])
    assert sorted(sinks[0].measured()) == sorted(MEASURED)
    repeated, sound = (
        next(s for s in each.manifest.segments if s.name == "rate_x_-50")
        for each in (first, second)
    )
    assert repeated.t_start > sound.t_end


@pytest.mark.rehearsal
@pytest.mark.real_time
def test_two_units_over_sockets(short, sinks):
    with serving(TWO, SPEED) as station:
        acquired = acquire(request(station, short, sinks))
    for sink in sinks:
        assert_whole(sink)
    assert [each.given_up for each in acquired] == [None, None]


@pytest.mark.parametrize(
    ("fields", "sentence"),
    [({"unit": {"serial": "V00001"}}, "same unit.serial: V00001"),
     ({"unit_link": {"url": "socket://in-memory:1"}}, "same unit_link.url")],
)  # fmt: skip
def test_two_units_of_one_serial_or_on_one_line_are_refused(fields, sentence):
    file = InMemoryStation(TWO).file.model_dump(mode="json")
    for name, changes in fields.items():
        file["other_units"][0][name] |= changes
    with pytest.raises(ValueError, match=sentence):
        StationFile.model_validate(file)


def log_of(kept) -> list[LogEntry]:
    return [LogEntry.model_validate(each) for each in kept.manifests[-1].model_extra["log"]]


@pytest.fixture(scope="module")
def watched(short, new_sink) -> tuple[Any, list[Progress]]:
    """A run on a sound station: what was kept, and what who watched it saw."""
    sink, seen = new_sink(), []
    InMemoryStation(VirtualStation()).acquire(short, sink, seen.append)
    return sink, seen


def test_every_state_of_a_run_is_kept_with_its_time_and_cause(watched):
    kept, _ = watched
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


def test_who_watches_sees_state_segment_rates_and_noise(watched):
    _, found = watched
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
