"""A run that was interrupted goes on as the same run."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

from schemas.base import BrokenOff, Unusable
from schemas.recording import MEASURED, Recording
from storage.catalogue import runs
from storage.formats.mcap.reader import has_readings, read_mcap
from storage.formats.mcap.writer import RawWriter
from storage.home import Home
from tasks.stages import acquire
from tasks.stages.acquire import acquire_run
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import StationFault
from tasks.station.virtual.unit import draw_unit
from tests.tasks.stages.test_acquire import POSITION, PROCEDURE
from tests.tasks.station.in_memory import InMemoryStation

PLACES = {"+z": [0, 0, 0], "-z": [0, 180, 0], "+y": [0, 90, 0], "-y": [0, 270, 0]}
FOUR = PROCEDURE.model_validate(
    PROCEDURE.model_dump()
    | {
        "steps": [
            POSITION | {"name": f"position_{up}_000", "up": up, "angles_deg": angles}
            for up, angles in PLACES.items()
        ]
    }
)
LOOKS = 3
NAMES = [f"position_{up}_000" for up in PLACES]


class Bench:
    """Runs on a station in this process; `restart` switches the station off and on."""

    speed = 20.0

    def __init__(self, home: Home, monkeypatch: pytest.MonkeyPatch) -> None:
        self.home, self._monkeypatch = home, monkeypatch
        self.begun: list[str] = []
        self.restart()

    def restart(self) -> None:
        self.use(VirtualStation(unit=draw_unit(7)))

    def use(self, config: VirtualStation, faults: Iterable[StationFault] = ()) -> None:
        self.station = InMemoryStation(config, speed=self.speed, faults=faults)
        self._monkeypatch.setattr(acquire, "acquire", self.station.run)

    def acquire(self, until: str = "", resume: bool = False, by: str = "Sun") -> Recording:
        """until: the segment in which the operator ends it, when the data before it are there."""
        self.begun.clear()
        looks = 0

        def report(progress) -> None:
            nonlocal looks
            if progress.now not in self.begun:
                self.begun.append(progress.now)
            looks += bool(until) and progress.now.startswith(until)
            if looks == LOOKS:
                raise KeyboardInterrupt

        made = acquire_run(self.station.file, FOUR, self.home, report, resume=resume, operator=by)
        ((run, _),) = made.kept
        return runs.load(run, self.home)

    def interrupt(self, until: str, resume: bool = False) -> Path:
        with pytest.raises(BrokenOff, match="--resume"):
            self.acquire(until, resume)
        (left,) = self.home.acquiring.glob("*.mcap")
        return left


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Bench:
    monkeypatch.delenv("MIMUCAL_DATABASE", raising=False)
    return Bench(Home(tmp_path / "home"), monkeypatch)


def measured(recording: Recording) -> list[str]:
    return [s.name for s in recording.manifest.segments or () if s.kind in MEASURED]


def assert_whole(recording: Recording) -> None:
    """Every segment with all of its samples, and nothing twice."""
    assert (np.diff(recording.imu.t) > 0).all()
    for segment in recording.manifest.segments or ():
        if segment.kind in MEASURED:
            for stream in (recording.imu, recording.table):
                t = stream.t[stream.rows(segment.t_start, segment.t_end)]
                assert np.diff(t) == pytest.approx(0.01, abs=1e-9)
            assert segment.t_end - segment.t_start == pytest.approx(6.0)


def test_it_goes_on_at_the_first_missing_segment_as_one_run(bench):
    bench.speed = 5.0  # so that little is lost while the operator ends it
    bench.restart()
    left = bench.interrupt("position +y")
    first = read_mcap(left, salvage=True)
    killed = left.with_name("killed.mcap")  # as it went on
    with RawWriter(killed) as again:
        again.manifest(first.manifest)
    killed.write_bytes(killed.read_bytes()[:-100])
    assert not has_readings(killed)
    whole = bench.acquire(resume=True, by="Qian")
    assert (whole.manifest.model_extra or {})["operator"] == "Sun; Qian"
    positions = [name for name in bench.begun if name.startswith("position")]
    assert positions == ["position +y 000", "position -y 000"]
    assert measured(whole) == NAMES
    assert_whole(whole)
    assert whole.manifest.recording_id == first.manifest.recording_id
    assert whole.imu.t[: len(first.imu)] == pytest.approx(first.imu.t, abs=0)
    assert list(bench.home.acquiring.glob("*.mcap")) == []
    parts = whole.manifest.model_extra["parts"]
    assert [part["t_start"] for part in parts] == [0.0, pytest.approx(first.imu.t[-1], abs=1.0)]


@pytest.mark.parametrize("end_s", [10.0, 18.0, 30.0])
def test_a_segment_whose_data_a_power_cut_took_is_measured_again(bench, end_s):
    left = bench.interrupt("position -y")
    recording = read_mcap(left, salvage=True)
    left.unlink()
    with RawWriter(left) as cut:
        cut.manifest(recording.manifest)
        for name, stream in recording.streams().items():
            cut.append(name, stream.at(stream.t < end_s))
    whole = bench.acquire(resume=True)
    assert sorted(measured(whole)) == sorted(NAMES)
    assert_whole(whole)


def test_the_station_may_have_been_restarted_and_the_run_broken_off_again(bench):
    bench.interrupt("position -z")
    bench.restart()
    bench.interrupt("position -y", resume=True)
    bench.restart()
    whole = bench.acquire(resume=True)
    assert measured(whole) == NAMES
    assert_whole(whole)
    assert len(whole.manifest.model_extra["parts"]) == 3


def test_where_no_run_was_interrupted_it_is_refused_with_the_way_out(bench):
    with pytest.raises(Unusable, match="without --resume"):
        bench.acquire(resume=True)


def test_a_unit_that_was_given_up_is_measured_to_the_end_later_and_alone(bench):
    config = VirtualStation(unit=draw_unit(7), neighbours=(draw_unit(8),))
    bench.use(config, [StationFault("unit_silent", 12.0)])
    made = acquire_run(bench.station.file, FOUR, bench.home, lambda _: None)
    ((run, acquired),) = made.kept
    assert measured(runs.load(run, bench.home)) == NAMES
    assert (run.serial, acquired.given_up) == ("V00008", None)
    (sentence,) = made.given_up
    (left,) = bench.home.acquiring.glob("*.mcap")
    assert "unit V00007 was given up: the unit on" in str(sentence)
    assert f"recorded so far: {left} (`mimucal acquire --resume`" in str(sentence)
    bench.use(config)
    again = acquire_run(bench.station.file, FOUR, bench.home, lambda _: None, resume=True)
    ((other, _),) = again.kept
    assert other.serial == "V00007"
    assert measured(runs.load(other, bench.home)) == NAMES
    assert_whole(runs.load(other, bench.home))
    assert list(bench.home.acquiring.glob("*.mcap")) == []
