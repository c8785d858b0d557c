"""`mimucal upgrade`, its way back, and giving that up, as sentences."""

from dataclasses import dataclass
from typing import Literal

from flows.terminal import counting, working
from storage.backup import restore
from storage.catalogue.database import HEAD
from storage.home import home
from tasks.version import code_version


@dataclass(frozen=True)
class Done:
    """What became of it; refused: the check found faults, and nothing was changed."""

    done: Literal["nothing", "upgraded", "back", "confirmed", "refused"]
    sentences: list[str]


def upgraded() -> Done:
    """Checks on a copy, then upgrades."""
    if not restore.is_needed(home()):
        return Done("nothing", ["The catalogue needs no upgrade."])
    with counting("checking on a copy") as report:
        faults = restore.rehearse(home(), code_version(), report)
    if faults:
        found = [f"{fault.what}: {fault.why}" for fault in faults]
        end = "Nothing was changed: put this right with the version of mimucal that made it."
        return Done("refused", [*found, end])
    with working("upgrading"):
        before = restore.upgrade(home(), code_version())
    return Done("upgraded", [
        f"The catalogue is upgraded from revision {before} to {HEAD}.",
        "The way back stays until `mimucal upgrade --confirm`; `mimucal upgrade --back` takes it.",
    ])  # fmt: skip


def went_back() -> Done:
    """Takes the way back."""
    with working("going back"):
        revision, newer = restore.back(home(), code_version())
    rows = ", ".join(f"{count} of {name}" for name, count in newer.items())
    kept = f"Left out, and kept in {home().path / 'upgrade-left'}: rows that came since: {rows}."
    return Done("back", [
        f"The catalogue is back at revision {revision}: go on with the version that made it.",
        *([kept] if newer else []),
    ])  # fmt: skip


def confirmed() -> Done:
    """Gives up the way back."""
    restore.confirm(home())
    return Done("confirmed", ["The upgrade is confirmed; there is no way back."])
