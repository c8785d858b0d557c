"""Stage: stops a station. It needs the station's own computer, or its network, and nothing else."""

import getpass
import os
import pwd
import threading
import time
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from secrets import token_hex

from schemas.base import NotThere, Unusable
from schemas.recording import ENDED
from schemas.station import StationFile, StopAnswer, Stopped, StopRequest
from storage import settings, stations
from storage.home import Home
from storage.stations import (
    answer_in,
    end_status,
    is_dead,
    is_held,
    kept_station_file,
    lock_out,
    note_in_trail,
    read_status,
    request_stop,
    status_file_of,
    take_back,
)
from tasks.words import cause_of, message, statement

ANSWER_S = 1.0  # time allowed for the run's process to command every axis
LOOK_S = 0.02
TRAIL_S = 0.5
REST_S = 30.0  # time allowed for a process that has answered to bring the table to rest


def stop_station(station: str, by: str, home: Home, lockout: bool = True) -> Stopped:
    """Stop a station, and read that its table is at rest.

    station: its id, or a station file. lockout: whether the station's orders then wait until
    somebody releases it, as after every stop by a person.

    The process of a run that goes on there stops it, keeps the recording and ends; where none
    answers within ANSWER_S, the table is stopped from here by its station file. Neither database
    nor Prefect nor, where MIMUCAL_STATION names a folder of this computer, the home are needed.
    Raises Unusable for a station that is not known.
    """
    began_s = time.monotonic()
    file, unknown = _file(station, home)
    id_ = file.station.id if file else station
    request = StopRequest(key=token_hex(8), station=id_, by=by, at=datetime.now(UTC))
    if lockout:
        lock_out(request, home)
    is_written = request_stop(request, home)
    answer = _answer(request, home) if is_written and _lives(id_, home) else None
    if answer is not None and answer.at_rest:
        stopped = Stopped(
            station=id_, by=by, at_rest=True, axes=answer.axes, way="run", seconds=0.0
        )
    elif file is not None:
        stopped = _directly(file, by)
    else:
        take_back(home.locks, id_)
        raise unknown or NotThere(f"station {id_} is not known")
    if not is_held(id_, home):
        take_back(home.locks, id_)
        if stopped.at_rest and not _lives(id_, home):
            from tasks.station.connected_station import stopped_by  # late, as below

            end_status(id_, f"stopped by {by}", home, statement(stopped_by(by)))
    seconds = time.monotonic() - began_s
    _enter_in_trail(request, home)
    return stopped.model_copy(
        update={"recordings": _recordings(id_, home), "seconds": round(seconds, 3)}
    )


def _enter_in_trail(request: StopRequest, home: Home) -> None:
    """Within TRAIL_S, in a thread that nobody waits for: a stop needs no database, and the release
    after it enters what is missing.
    """

    def enter() -> None:
        with suppress(Exception):
            note_in_trail(request, home)

    entering = threading.Thread(target=enter, daemon=True)
    entering.start()
    entering.join(TRAIL_S)


def current_user() -> str:
    """The person at this terminal: MIMUCAL_USER, else the login. Never fails: a stop waits for
    nothing.
    """
    try:
        return os.environ.get("MIMUCAL_USER") or getpass.getuser()
    except (KeyError, OSError):  # OSError from Python 3.13 on
        return login()


def login() -> str:
    """The login of this process's account, whatever its environment says; its number where it has
    no name, as in a container.
    """
    try:
        return pwd.getpwuid(os.geteuid()).pw_name
    except KeyError:
        return f"uid {os.geteuid()}"


def _file(station: str, home: Home) -> tuple[StationFile | None, Unusable | None]:
    """The station file: one that is named, that of the last run here, or that of the home."""
    if Path(station).is_file():
        return settings.read(Path(station), StationFile), None
    if kept := kept_station_file(station, home):
        return kept, None
    try:
        return settings.read(stations.file_of(station, home), StationFile), None
    except Unusable as fault:
        return None, fault
    except OSError as fault:
        return None, Unusable(str(fault))


def _lives(station: str, home: Home) -> bool:
    """Whether a process holds the station, on this computer or, by its status, on another."""
    if is_held(station, home):
        return True
    status = read_status(status_file_of(station, home.status))
    return status is not None and status.state not in ENDED and not is_dead(status, home)


def _answer(request: StopRequest, home: Home) -> StopAnswer | None:
    """The answer of the run's process: at rest, or how far it got; None if there is none."""
    end_s = time.monotonic() + ANSWER_S
    answer = None
    while time.monotonic() < end_s:
        if (found := answer_in(home.locks, request)) is not None:
            if found.at_rest is not None:
                return found
            end_s = end_s if answer else time.monotonic() + REST_S
            answer = found
        if not _lives(request.station, home):  # it has ended
            return answer
        time.sleep(LOOK_S)
    return answer


def _directly(file: StationFile, by: str) -> Stopped:
    # late: the drivers take longer to import than a run's process needs to answer
    from tasks.station.connected_station import axes_of, is_at_rest, stop_directly

    id_, state, fault, cause = file.station.id, None, "", None
    try:
        state = stop_directly(file)
    except Unusable as silent:
        fault, cause = str(silent), cause_of(silent)
    at_rest = state is not None and is_at_rest(state)
    if state is not None and not at_rest:
        cause = statement(message("station-cause.still-turns"))
        fault = "the table still turns although it was commanded to stop"
    return Stopped(
        station=id_, by=by, at_rest=at_rest, axes=axes_of(file, state), way="directly",
        fault=fault, cause=cause, seconds=0.0,
    )  # fmt: skip


def _recordings(station: str, home: Home) -> tuple[str, ...]:
    """What the last run of the station left."""
    status = read_status(status_file_of(station, home.station_status)) or read_status(
        status_file_of(station, home.status)
    )
    return status.recordings if status is not None else ()
