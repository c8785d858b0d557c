"""Log of logins and refusals.

Each is a line of the logger `mimucal.access`; what an auditor asks about is an entry of the trail,
too. Unauthenticated input is made printable and short, and is never recorded as the person of an
entry.
"""

import logging
from typing import Any

from schemas.base import Unusable
from storage.catalogue import audit_trail, database
from storage.home import Home

LOGGER = logging.getLogger("mimucal.access")
UNKNOWN = "unknown"  # the person of a refused action who was not identified
LONGEST = 200  # characters of what a stranger sent


def plain(sent: object) -> str:
    """What a stranger sent, short and printable."""
    return "".join(sign if sign.isprintable() else "?" for sign in str(sent)[:LONGEST])


def refused(home: Home, action: str, subject: str, *, person: str = UNKNOWN, **about: Any) -> None:
    """Logs what was refused, and enters it in the trail of a home that has one.

    A catalogue that does not answer costs the entry, not the refusal.
    """
    kept: dict[str, Any] = {
        name: plain(value) for name, value in about.items() if value is not None
    }
    LOGGER.warning("%s %s refused to %s: %s", action, plain(subject), person, kept)
    if not home.path.is_dir():
        return
    try:
        with database.changing(home) as connection:
            audit_trail.add(connection, person, f"refuse {action}", plain(subject), **kept)
    except Unusable as fault:
        LOGGER.error("the trail could not be written: %s", fault)
