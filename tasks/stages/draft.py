"""Stores a draft certificate: one for each run and purpose, the latest."""

from datetime import datetime

import sqlalchemy as sql

from schemas.base import Unusable
from schemas.certificate import Certificate
from storage.catalogue import database, keep_certificate, trail
from storage.catalogue.certificates import Entry, record_of
from storage.home import Home
from tasks.certificate.documents import faces_of
from tasks.stages.published import Published, published
from tasks.words import message

DRAFT = "draft"  # the number of a draft that has no key yet
UNNAMED_DRAFTER = "not named"  # who drafted, if not named


def keep_draft(
    certificate: Certificate, home: Home, now: datetime, evidence: bytes | None = None
) -> Published:
    """Keeps a draft in the place of the one before it of the same run and purpose.

    Raises Unusable where a certificate of that run and purpose is issued, unless this one amends
    it, and where the draft before amends another certificate and this one does not.
    """
    with database.changing(home) as connection:
        result = keep_certificate.result_of(connection, certificate)
        before = _before(connection, certificate, home)
        run = certificate.calibration.run
        earlier = [entry for entry in before if entry.purpose is None]  # has a number: it stays
        dropped = [entry for entry in before if entry.purpose is not None]
        own = next((entry.number for entry in dropped if entry.run == run), None)
        key = own or keep_certificate.free_key(connection, run)
        for entry in dropped:
            keep_certificate.remove(connection, entry)
        for entry in earlier:
            keep_certificate.change_state(connection, entry.number, "withdrawn")
        draft = certificate.model_copy(update={"number": key})
        files = keep_certificate.add(connection, home, draft, faces_of(draft, None, evidence))
        step, replaces = draft.step("draft"), draft.replaces
        person = step.person if step else UNNAMED_DRAFTER
        for entry in earlier:
            trail.add(connection, person, "withdraw", entry.number, at=now, reason=f"draft {key}")
        trail.add(
            connection, person, "draft", key, at=now, run=run, result=result,
            purpose=draft.purpose, reason=step.reason if step else None,
            replaces=replaces and replaces.number, dropped=[entry.number for entry in dropped],
            sha256=keep_certificate.hashes(connection, key),
        )  # fmt: skip
    keep_certificate.remove_files(dropped, files, home)
    return published(key, home)


def _before(connection: sql.Connection, certificate: Certificate, home: Home) -> list[Entry]:
    """The drafts that this one replaces; raises Unusable if it may not."""
    run, replaces = certificate.calibration.run, certificate.replaces
    found = {
        entry.number: entry
        for entry in keep_certificate.live(connection, run)
        if (entry.purpose or _purpose_of(entry, home)) == certificate.purpose
    }
    if replaces:
        found |= {
            entry.number: entry
            for entry in keep_certificate.drafts_in_place_of(connection, replaces.number)
        }
        found.pop(replaces.number, None)
    for entry in found.values():
        if entry.state == "issued":
            raise Unusable(
                f"run {run} has certificate {entry.number}, issued on {entry.issued_on}; "
                f"`mimucal amend {entry.number} --why REASON` makes another one in its place.",
                message("cause-state.issued", number=entry.number),
            )
        other = entry.supersedes if not replaces or replaces.number != entry.supersedes else None
        if other and _is_issued(connection, other):
            raise Unusable(
                f"draft {entry.number} of run {run} amends certificate {entry.supersedes}; "
                f"`mimucal amend {entry.supersedes} --why REASON` makes it again."
            )
    return list(found.values())


def _is_issued(connection: sql.Connection, number: str) -> bool:
    """Otherwise it cannot be replaced any more: it was withdrawn, or already amended."""
    entry = keep_certificate.locked(connection, number)
    return entry is not None and entry.state == "issued"


def _purpose_of(entry: Entry, home: Home) -> str | None:
    """The purpose of what an earlier version kept; None for a record that cannot be read."""
    try:
        return record_of(entry, home).purpose
    except Unusable:
        return None
