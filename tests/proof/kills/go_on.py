"""An acquisition that is killed and then goes on with `--resume`."""

from pathlib import Path

from schemas.base import Unusable
from schemas.procedure import Procedure
from schemas.station import StationFile
from storage.catalogue.run_index import Run
from storage.home import Home
from tasks.stages.acquire import acquire_run
from tasks.stages.left_run import left_runs
from tasks.station.acquisition import Acquired
from tasks.station.run_manifest import interrupted
from tasks.station.virtual.config import VirtualStation
from tests.proof.faults.outcome import comes_to_rest
from tests.proof.kills.kill import acquire_and_kill
from tests.tasks.station.over_sockets import ignore

SPEED = 40.0
ATTEMPTS = 5  # to go on: a computer that is too busy stops a run, too


def killed_and_resumed(
    station: StationFile, procedure: Procedure, home: Home, after_s: float
) -> tuple[Run, Acquired, int]:
    """A run that is killed so long (s) after its first bytes, and then goes on; and how many of
    its measured segments stood after the kill.

    Where the kill left no reading, it begins anew. Raises Unusable where the table did not come to
    rest after the kill, and as `acquire_run` does.
    """
    acquire_and_kill(*_files(station, procedure, home.path), home.path, after_s)
    if not comes_to_rest(station, VirtualStation().unit.gyro.lsb):
        raise Unusable("the table still turns, long after the acquisition was killed")
    stood = _standing(station, procedure, home) or 0
    for _ in range(ATTEMPTS):
        resume = _standing(station, procedure, home) is not None
        try:
            (kept,) = acquire_run(station, procedure, home, ignore, resume=resume).kept
        except Unusable as stop:
            last = stop
        else:
            return *kept, stood
    raise last


def _files(station: StationFile, procedure: Procedure, folder: Path) -> tuple[Path, Path]:
    folder.mkdir(parents=True, exist_ok=True)
    files = folder / "station.json", folder / "procedure.json"
    for file, content in zip(files, (station, procedure), strict=True):
        file.write_text(content.model_dump_json(), encoding="utf-8")
    return files


def _standing(station: StationFile, procedure: Procedure, home: Home) -> int | None:
    """How many measured segments of the interrupted run stand; None where there is none."""
    try:
        (left,) = left_runs(station, procedure, home).values()
    except Unusable:
        return None
    return len(interrupted(left.recording, station.unit_link).measured())
