"""Whether register, trail and number series agree about every certificate."""

import json
from collections.abc import Iterator

from schemas.certificate import State
from storage.catalogue import certificates, numbers, trail
from storage.home import Home

RESTORE = "bring the catalogue back from a backup"
AFTER: dict[str, State] = {
    "draft": "draft",
    "check": "checked",
    "issue": "issued",
    "amend": "amended",
    "withdraw": "withdrawn",
}
Standing = tuple[State, list[str | None]]  # what became of it, and the SHA-256 of its files


def against_trail(home: Home) -> Iterator[str]:
    """Certificates of which the register does not say what the trail does.

    Looked at twice: what others change in between is no fault.
    """
    first = set(_differences(home))
    if first:
        yield from (fault for fault in _differences(home) if fault in first)


def number_gaps(home: Home) -> Iterator[str]:
    """Numbers that were given and are gone."""
    for number in numbers.missing(home):
        yield f"{number} was given and is not in the register; {RESTORE}"


def _differences(home: Home) -> Iterator[str]:
    standing = _standing(home)
    register = {entry.number: entry for entry in certificates.register(home)}
    for number, (state, hashes) in standing.items():
        entry = register.get(number)
        if entry is None:
            yield f"{number} is {state} in the trail and is not in the register; {RESTORE}"
            continue
        if entry.state != state:
            yield f"{number} is {state} in the trail and {entry.state} in the register; {RESTORE}"
        if hashes and hashes != [entry.pdf_sha256, entry.dcc_sha256, entry.record_sha256]:
            yield f"{number} has other files in the register than in the trail; {RESTORE}"
    for number in register.keys() - standing.keys():
        if register[number].purpose is not None:  # an earlier version kept no trail
            yield f"{number} is in the register, and the trail does not know it; {RESTORE}"


def _standing(home: Home) -> dict[str, Standing]:
    """What the trail says of each certificate; the key of a draft is gone with its issue."""
    standing: dict[str, Standing] = {}
    for entry in trail.entries(home):
        if entry.action not in AFTER:
            continue
        details = json.loads(entry.details)
        for gone in (*details.get("dropped", ()), details.get("draft")):
            standing.pop(gone, None)
        before = standing.get(entry.subject, ("draft", []))[1]
        standing[entry.subject] = AFTER[entry.action], details.get("sha256", before)
    return standing
