"""Stage: adds the recording of a whole run to the catalogue, for as long as that takes.

What was measured is never measured again: a recording waits in the home's `acquired` folder until
the catalogue and the store take it.
"""

import shutil
import time
from collections.abc import Callable
from pathlib import Path

import sqlalchemy as sql

from schemas.base import BrokenOff, Unusable
from schemas.recording import Recording
from storage.blobs import Unreachable, blobs_of
from storage.catalogue import database, runs, tables
from storage.catalogue.database import Busy
from storage.catalogue.runs import Run
from storage.formats.mcap.reader import read_mcap
from storage.home import Home
from storage.stations import one_run_on
from tasks.stages.stage import notify, stage
from tasks.station.connected_station import OPERATOR, StopRequested
from tasks.words import cause_of, clauses, message

FIRST_PAUSE_S, LONGEST_PAUSE_S = 1.0, 60.0  # between two attempts
PATIENCE_S = 12 * 3600.0  # a night without anybody to repair the database


@stage("store", again=False)
def store(
    recording: Path,
    home: Home,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> Run:
    """Add a recording to the catalogue and remove its file, once catalogue and store answer.

    Raises BrokenOff, naming the file, where they do not for PATIENCE_S, or the operator ends it.
    """
    end_s, pause_s = clock() + PATIENCE_S, FIRST_PAUSE_S
    try:
        content = read_mcap(recording)  # once: another run of this home may store the file
        while True:
            try:
                return _added(content, recording, home)
            except Unusable as fault:
                if not is_transient(fault) or clock() + pause_s > end_s:
                    raise
                notify(f"{recording} waits to be stored, again in {pause_s:.0f} s: {fault}")
            sleep(pause_s)
            pause_s = min(2.0 * pause_s, LONGEST_PAUSE_S)
    except Unusable as fault:
        raise BrokenOff(f"{str(fault).rstrip('.')}{_waits(recording)}") from fault
    except (KeyboardInterrupt, StopRequested) as stop:
        raise BrokenOff(f"stopped by {str(stop) or OPERATOR}{_waits(recording)}") from stop


def store_waiting(home: Home) -> None:
    """Adds what earlier runs could not store; what still cannot be stored waits."""
    for recording in sorted(home.acquired.glob("*.mcap")):
        try:
            _added(read_mcap(recording), recording, home)
        except Unusable as fault:
            notify(f"{recording} still waits to be stored: {fault}")


def is_transient(fault: Unusable) -> bool:
    """Whether waiting helps: a catalogue or a store that does not answer, a disk that refuses."""
    return isinstance(fault, Busy | Unreachable) or isinstance(fault.__cause__, OSError)


def _added(content: Recording, recording: Path, home: Home) -> Run:
    run, _ = runs.add(content, home)
    recording.unlink(missing_ok=True)
    return run


def _waits(recording: Path) -> str:
    return (
        f"; the run is whole in {recording}, and the next run of this home or `mimucal import "
        f"{recording}` stores it"
    )


# Whether a run can begin: nothing turns unless what it measures can be kept.

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
    """How much is free on the disk of a folder, which need not exist yet."""
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
