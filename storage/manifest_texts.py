"""What no text and no number in a manifest may be, wherever in it."""

import math
from collections.abc import Iterator, Mapping
from typing import Any
from unicodedata import category

from schemas.base import Unusable
from schemas.recording import Manifest, Segment, Station, TableAxis, Unit

KNOWN = {n for m in (Manifest, Unit, Station, TableAxis, Segment) for n in m.model_fields}
LAYOUT = "\t\n\r"  # allowed in remarks, which are fields that the format does not know


def check_values(fields: object, where: str) -> None:
    """Raises Unusable for a number that is not finite and for half a surrogate pair."""
    for place, _, value in _leaves(fields):
        if isinstance(value, float) and not math.isfinite(value):
            raise Unusable(
                f"{where}: {_plain(place)} is {value} (NaN, Infinity, or beyond 1.8e308); "
                "give a finite number there, or null where it is unknown."
            )
        if isinstance(value, str) and any(category(sign) == "Cs" for sign in value):
            raise Unusable(
                f"{where}: {_plain(place)} is {value[:40]!a}, with half of a surrogate pair, "
                "which is no character; write the whole character."
            )


def check_controls(fields: Mapping[str, Any], where: str) -> None:
    """Raises Unusable for control characters, which no label or certificate can print.

    Tabs and line ends may stand in remarks.
    """
    for place, key, value in _leaves(fields):
        allowed = "" if key in KNOWN else LAYOUT
        if isinstance(value, str) and any(
            category(sign) == "Cc" and sign not in allowed for sign in value
        ):
            raise Unusable(
                f"{where}: {_plain(place)} is {value[:40]!a}, with a control character in it; "
                "remove that character."
            )


def _leaves(value: Any, place: str = "", key: str = "") -> Iterator[tuple[str, str, Any]]:
    """Every value that holds no others, and every name, with its place and its nearest name."""
    if isinstance(value, Mapping):
        for name, inner in value.items():
            path = f"{place}.{name}" if place else name
            yield path, name, name
            yield from _leaves(inner, path, name)
    elif isinstance(value, list | tuple):
        for number, inner in enumerate(value):
            yield from _leaves(inner, f"{place}.{number}", key)
    else:
        yield place, key, value


def _plain(place: str) -> str:
    return place[:80].encode("unicode_escape").decode() if not place.isprintable() else place[:80]
