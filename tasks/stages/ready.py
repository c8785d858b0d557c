"""Whether a run can begin: nothing turns unless what it measures can be kept."""

import shutil
from collections.abc import Callable
from pathlib import Path

import sqlalchemy as sql

from schemas.base import Unusable
from storage.blobs import blobs_of
from storage.catalogue import database, tables
from storage.home import Home
from storage.station_lock import one_run_on
from tasks.words import cause_of, clauses, message

FREE_BYTES = 2 << 30  # on the disk: ten runs of an hour


def ready_to_acquire(station: str, home: Home) -> None:
    """Raises Unusable, naming every obstacle, unless catalogue, store, disk and station are ready.

    station: its id.
    """
    looks: tuple[Callable[[], None], ...] = (
        lambda: _catalogue_is_writable(home),
        lambda: _store_answers(home),
        lambda: _disk_has_room(home),
        lambda: _station_is_free(station, home),
    )
    faults = [fault for look in looks if (fault := _fault_of(look))]
    if faults:
        sentence = "; ".join(str(fault).rstrip(".") for fault in faults)
        raise Unusable(
            sentence, clauses([cause_of(fault) for fault in faults], "station-cause.and")
        )


def free_bytes(folder: Path) -> int:
    """On the disk of a folder, which need not exist yet."""
    there = next(each for each in (folder, *folder.parents) if each.exists())
    return shutil.disk_usage(there).free


def _fault_of(look: Callable[[], None]) -> Unusable | None:
    try:
        look()
    except Unusable as fault:
        return fault
    return None


def _catalogue_is_writable(home: Home) -> None:
    """A statement that changes nothing is refused like any other, as by a standby server."""
    with database.changing(home) as connection:
        nothing = sql.update(tables.units).where(sql.false()).values(serial="")
        connection.execute(nothing)


def _store_answers(home: Home) -> None:
    blobs_of(home).exists("raw/0.mcap")


def _disk_has_room(home: Home) -> None:
    free = free_bytes(home.acquiring)
    if free < FREE_BYTES:
        raise Unusable(
            f"the disk of {home.acquiring} has {free / 2**30:.1f} GiB free, and a run may need "
            f"{FREE_BYTES / 2**30:.0f} GiB: free some space",
            message(
                "station-cause.disk", free=f"{free / 2**30:.1f}", needed=f"{FREE_BYTES / 2**30:.0f}"
            ),
        )


def _station_is_free(station: str, home: Home) -> None:
    with one_run_on(station, home):
        pass
