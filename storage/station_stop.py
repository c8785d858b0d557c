"""Requests to stop a station, what its run answers, and lockouts: files beside its lock.

They need nothing but the folder: no database, no server. A request that another computer makes
lies in the home, where the run looks as well.
"""

from contextlib import suppress
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from schemas.base import Unusable
from schemas.station import StationFile
from schemas.stop import StopAnswer, StopRequest
from storage.home import Home
from storage.station_lock import hashed
from storage.whole_files import drafted

M = TypeVar("M", bound=BaseModel)


def request_in(folder: Path, station: str) -> StopRequest | None:
    """The request in a folder of locks; None where there is none."""
    return _read(folder / f"{hashed(station)}.stop", StopRequest)


def request_stop(request: StopRequest, home: Home) -> bool:
    """Leave a request where the station's run looks; whether it could be written."""
    return _write(request, home.locks / f"{hashed(request.station)}.stop")


def take_back(folder: Path, station: str) -> None:
    """Remove a request that has had its answer, or was of an earlier run."""
    with suppress(OSError):
        (folder / f"{hashed(station)}.stop").unlink(missing_ok=True)


def answer_in(folder: Path, request: StopRequest) -> StopAnswer | None:
    """The answer to this request; None where there is none yet."""
    answer = _read(folder / f"{hashed(request.station)}.stopped", StopAnswer)
    return answer if answer is not None and answer.key == request.key else None


def answer_stop(answer: StopAnswer, folder: Path, station: str) -> None:
    """Answer a request in the folder in which it lies."""
    _write(answer, folder / f"{hashed(station)}.stopped")


def note_in_trail(request: StopRequest, home: Home) -> None:
    """Enter a stop in the audit trail, once; who released it sees to it where that failed."""
    from storage.catalogue import database, trail  # late: a stop does not wait for their import

    if database.for_reading(home) is None:
        return
    with database.changing(home) as connection:
        trail.add_once(
            connection, request.by, "stop station", request.station, at=request.at, key=request.key
        )


def lock_out(request: StopRequest, home: Home) -> None:
    """Keep the orders of a station waiting after a stop, until somebody releases it."""
    _write(request, home.locks / f"{hashed(request.station)}.lockout")


def lockout_of(station: str, home: Home) -> StopRequest | None:
    """The stop after which nobody has released the station yet; None where it is released."""
    folders = (home.locks, home.shared_locks)
    found = (_read(folder / f"{hashed(station)}.lockout", StopRequest) for folder in folders)
    return next((each for each in found if each is not None), None)


def release(station: str, by: str, home: Home) -> None:
    """Let the orders of a station begin again, and enter in the audit trail who saw that it may
    turn, and the stop before; raises Unusable where that cannot be written.
    """
    from storage.catalogue import database, trail  # late, as above

    stop = lockout_of(station, home)
    if stop is not None:
        note_in_trail(stop, home)
        with database.changing(home) as connection:
            trail.add(connection, by, "release station", station, key=stop.key)
    for folder in (home.locks, home.shared_locks):
        file = folder / f"{hashed(station)}.lockout"
        try:
            file.unlink(missing_ok=True)
        except OSError as error:
            raise Unusable(
                f"{file} cannot be removed ({error.strerror}), and station {station} stays locked "
                "out: give rights there, or remove it"
            ) from error


def keep_station_file(station: StationFile, home: Home) -> None:
    """Keep the file by which a station is run, so that it can be stopped without the home."""
    _write(station, home.locks / f"{hashed(station.station.id)}.station.json")


def kept_station_file(station: str, home: Home) -> StationFile | None:
    """The file by which a station was run last; None where it was never run here."""
    return _read(home.locks / f"{hashed(station)}.station.json", StationFile)


def _read(file: Path, model: type[M]) -> M | None:
    with suppress(OSError, ValidationError):
        return model.model_validate_json(file.read_bytes())
    return None


def _write(content: BaseModel, file: Path) -> bool:
    """The folder itself is made where only it is missing, and not where a disk is away."""
    with suppress(OSError):
        if file.parent.parent.is_dir():
            file.parent.mkdir(exist_ok=True)
        with drafted(file) as draft:
            draft.write_text(content.model_dump_json(), encoding="utf-8")
        return True
    return False
