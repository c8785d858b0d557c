"""The status of the last run of each station, in a file that is always complete."""

from contextlib import suppress

from pydantic import ValidationError

from schemas.run_log import ENDED, RunStatus
from storage.home import Home
from storage.station_lock import is_held, lock_of
from storage.whole_files import drafted


def write_status(status: RunStatus, home: Home) -> None:
    """Write how a run stands. A disk that refuses costs the status, and not the run."""
    file = home.status / f"{lock_of(status.station, home).stem}.json"
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        with drafted(file) as draft:
            draft.write_text(status.model_dump_json(), encoding="utf-8")


def statuses(home: Home) -> list[tuple[RunStatus, bool]]:
    """The last run of each station, and whether its process is dead: it ended without a word."""
    found = []
    for file in sorted(home.status.glob("*.json")):
        with suppress(OSError, ValidationError):
            status = RunStatus.model_validate_json(file.read_bytes())
            is_dead = status.state not in ENDED and not is_held(status.station, home)
            found.append((status, is_dead))
    return found
