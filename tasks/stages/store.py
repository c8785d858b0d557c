"""Stage: adds the recording of a whole run to the catalogue, for as long as that takes.

What was measured is never measured again: a recording waits in the home's `acquired` folder until
the catalogue and the store take it.
"""

import time
from collections.abc import Callable
from pathlib import Path

from schemas.base import BrokenOff, Unusable
from schemas.recording import Recording
from storage.blobs import Unreachable
from storage.catalogue import runs
from storage.catalogue.connection import Busy
from storage.catalogue.run_index import Run
from storage.formats.mcap.reader import read_mcap
from storage.home import Home
from tasks.stages.stage import notify, stage
from tasks.station.stopping import OPERATOR, StopRequested

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
