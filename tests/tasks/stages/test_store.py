"""The recording of a whole run waits for the catalogue, and is stored in the end."""

from pathlib import Path

import pytest

from schemas.base import BrokenOff, Unusable
from storage.blobs import Unreachable
from storage.catalogue import runs
from storage.catalogue.database import Busy
from storage.formats.mcap.writer import write_mcap
from storage.stations import one_run_on
from tasks.stages import acquire
from tasks.stages import store as storing
from tasks.stages.acquire import acquire_run
from tasks.stages.import_recording import import_recording
from tasks.stages.store import LONGEST_PAUSE_S, PATIENCE_S, ready_to_acquire, store, store_waiting
from tasks.station.virtual.config import VirtualStation, draw_unit
from tests.tasks.stages.test_acquire import PROCEDURE_ACQUIRE
from tests.tasks.station.in_memory import InMemoryStation


class Clock:
    """A clock that only sleeping advances, and what is away until a moment."""

    def __init__(self) -> None:
        self.now_s, self.pauses = 0.0, []

    def __call__(self) -> float:
        return self.now_s

    def sleep(self, pause_s: float) -> None:
        self.pauses.append(pause_s)
        self.now_s += pause_s


@pytest.fixture
def recording(fresh, ideal_run) -> Path:
    path = fresh.acquired / "whole.mcap"
    path.parent.mkdir(parents=True)
    write_mcap(ideal_run(), path)
    return path


def away_until(moment_s: float, clock: Clock, fault: Unusable, monkeypatch) -> None:
    add = runs.add

    def added(*arguments):
        if clock.now_s < moment_s:
            raise fault
        return add(*arguments)

    monkeypatch.setattr(storing.runs, "add", added)


@pytest.mark.parametrize("fault", [Busy("the database is away."), Unreachable("no bucket")])
def test_it_is_stored_once_the_catalogue_is_back_after_hours(
    fresh, recording, monkeypatch, capsys, fault
):
    clock = Clock()
    away_until(3 * 3600.0, clock, fault, monkeypatch)
    run = store(recording, fresh, clock, clock.sleep)
    assert [each.id for each in runs.all_runs(fresh)] == [run.id]
    assert not recording.exists()
    assert clock.pauses[:7] == [1, 2, 4, 8, 16, 32, 60]
    assert max(clock.pauses) == LONGEST_PAUSE_S
    assert f"{recording} waits to be stored, again in 1 s: {fault}" in capsys.readouterr().err


def test_a_disk_without_room_is_waited_for_and_a_fault_of_the_recording_is_not(
    fresh, recording, monkeypatch
):
    clock = Clock()
    full = Unusable("no room")
    full.__cause__ = OSError(28, "No space left on device")
    away_until(100.0, clock, full, monkeypatch)
    store(recording, fresh, clock, clock.sleep)
    assert clock.now_s > 100.0
    recording.write_bytes(b"no recording")
    with pytest.raises(BrokenOff, match=r"mimucal import .*whole\.mcap"):
        store(recording, fresh, clock, pytest.fail)
    assert recording.exists()


def test_what_could_not_be_stored_stays_and_the_next_run_or_an_import_stores_it(
    fresh, recording, monkeypatch
):
    clock = Clock()
    with monkeypatch.context() as patch:
        away_until(2 * PATIENCE_S, clock, Busy("away"), patch)
        with pytest.raises(BrokenOff, match="the run is whole in"):
            store(recording, fresh, clock, clock.sleep)
        store_waiting(fresh)
    assert recording.exists()
    imported = import_recording(recording, fresh)
    assert imported.is_new
    assert not recording.exists()
    write_mcap(runs.load(imported.run, fresh), recording)
    store_waiting(fresh)
    assert not recording.exists()


def test_another_run_of_the_home_may_store_it_meanwhile(fresh, recording, monkeypatch):
    clock = Clock()
    away_until(5.0, clock, Busy("away"), monkeypatch)

    def by_another(pause_s: float) -> None:
        clock.sleep(pause_s)
        if clock.now_s >= 5.0:
            store_waiting(fresh)

    run = store(recording, fresh, clock, by_another)
    assert [each.id for each in runs.all_runs(fresh)] == [run.id]


def test_a_run_is_measured_once_however_long_it_waits_to_be_stored(fresh, monkeypatch):
    """The catalogue goes away while the table turns, and comes back a minute later."""
    station = InMemoryStation(VirtualStation(unit=draw_unit(7)))
    turned = []

    def once(request):
        turned.append(request)
        return station.run(request)

    monkeypatch.setattr(acquire, "acquire", once)
    add, refusals = runs.add, iter([Busy("away"), Busy("away")])

    def added(*arguments):
        for fault in refusals:
            raise fault
        return add(*arguments)

    monkeypatch.setattr(storing.runs, "add", added)
    monkeypatch.setattr(storing, "FIRST_PAUSE_S", 0.0)
    ((run, _),) = acquire_run(station.file, PROCEDURE_ACQUIRE, fresh, lambda _: None).kept
    assert len(turned) == 1
    assert [each.id for each in runs.all_runs(fresh)] == [run.id]


# Nothing turns unless what is measured can be kept.


def test_every_obstacle_is_named_at_once_and_nothing_turns(fresh, monkeypatch):
    station = InMemoryStation(VirtualStation(unit=draw_unit(7))).file
    monkeypatch.setattr(acquire, "acquire", pytest.fail)
    monkeypatch.setattr(storing, "FREE_BYTES", 1 << 70)
    monkeypatch.setenv("MIMUCAL_DATABASE", "postgresql://nobody@127.0.0.1:9/none")
    with one_run_on(station.station.id, fresh), pytest.raises(Unusable) as refusal:
        acquire_run(station, PROCEDURE_ACQUIRE, fresh, lambda _: None)
    sentence = str(refusal.value)
    for obstacle in ("The catalogue", "GiB free", "a run is going on at station"):
        assert obstacle in sentence
    assert "\n" not in sentence
    assert not list(fresh.acquiring.glob("*"))


def test_a_catalogue_that_only_reads_is_not_ready(fresh):
    ready_to_acquire("T1", fresh)
    catalogue = fresh.path / "catalog.sqlite"
    catalogue.write_bytes(b"no database at all, and too short for one" * 100)
    with pytest.raises(Unusable, match="The catalogue"):
        ready_to_acquire("T1", fresh)
