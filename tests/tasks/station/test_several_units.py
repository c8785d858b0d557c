"""Several units on one table: one run, a recording of each."""

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.station import StationFile
from tasks.station.acquisition import Acquired, NewRecording, RunRequest, acquire
from tasks.station.progress import Progress
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import StationFault
from tasks.station.virtual.unit import draw_unit
from tests.tasks.station.in_memory import InMemoryStation
from tests.tasks.station.in_thread import serving
from tests.tasks.station.over_sockets import MEASURED, SPEED, ignore

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
    begun: list[str] = []

    def spoil_once(progress: Progress) -> None:
        begun.append(progress.now)
        first = progress.now == "rate x -50 deg/s" and "rate x +100 deg/s" not in begun
        station.simulation.faults = (StationFault("unit_drops"),) if first else ()

    first, second = station.run(request(station.file, short, sinks, spoil_once))
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
