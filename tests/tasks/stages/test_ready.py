"""Nothing turns unless what is measured can be kept."""

import pytest

from schemas.base import Unusable
from storage.home import Home
from storage.station_lock import one_run_on
from tasks.stages import acquire, ready
from tasks.stages.acquire import acquire_run
from tasks.stages.ready import ready_to_acquire
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.unit import draw_unit
from tests.tasks.stages.test_acquire import PROCEDURE
from tests.tasks.station.in_memory import InMemoryStation


def test_every_obstacle_is_named_at_once_and_nothing_turns(fresh: Home, monkeypatch) -> None:
    station = InMemoryStation(VirtualStation(unit=draw_unit(7))).file
    monkeypatch.setattr(acquire, "acquire", pytest.fail)
    monkeypatch.setattr(ready, "FREE_BYTES", 1 << 70)
    monkeypatch.setenv("MIMUCAL_DATABASE", "postgresql://nobody@127.0.0.1:9/none")
    with one_run_on(station.station.id, fresh), pytest.raises(Unusable) as refusal:
        acquire_run(station, PROCEDURE, fresh, lambda _: None)
    sentence = str(refusal.value)
    for obstacle in ("The catalogue", "GiB free", "a run is going on at station"):
        assert obstacle in sentence
    assert "\n" not in sentence
    assert not list(fresh.acquiring.glob("*"))


def test_a_catalogue_that_only_reads_is_not_ready(fresh: Home) -> None:
    ready_to_acquire("T1", fresh)
    catalogue = fresh.path / "catalog.sqlite"
    catalogue.write_bytes(b"no database at all, and too short for one" * 100)
    with pytest.raises(Unusable, match="The catalogue"):
        ready_to_acquire("T1", fresh)
