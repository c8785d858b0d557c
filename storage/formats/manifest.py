"""Reads a manifest, and checks every text and number in it."""

import json
import math
from collections.abc import Iterator, Mapping
from typing import Any
from unicodedata import category

from pydantic import ValidationError

from schemas.base import Unusable, first_fault
from schemas.recording import FORMAT, Manifest, Segment, Station, TableAxis, Unit
from storage.whole_files import check_depth

KNOWN = {n for m in (Manifest, Unit, Station, TableAxis, Segment) for n in m.model_fields}
MANIFEST = "manifest.json"
LAYOUT = "\t\n\r"  # allowed in remarks, which are fields that the format does not know


def manifest_of(text: bytes | str, where: str) -> Manifest:
    """The manifest in a JSON text; raises Unusable naming `where` and the first fault."""
    try:
        fields = json.loads(text.decode("utf-8-sig") if isinstance(text, bytes) else text)
        check_depth(fields)
        check_values(fields, where)
    except UnicodeError as error:
        raise Unusable(f"{where} is not UTF-8 text ({error}); save it as UTF-8.") from error
    except (ValueError, RecursionError) as error:
        raise Unusable(f"{where} is not JSON ({error}); correct it there.") from error
    if not isinstance(fields, dict):
        raise Unusable(f"{where} holds a {type(fields).__name__}, not a JSON object in braces.")
    if fields.get("format") != FORMAT:
        form = fields.get("format")
        raise Unusable(f"{where}: format is {form!r}; this program reads {FORMAT!r}.")
    try:
        return Manifest.model_validate(fields)
    except ValidationError as error:
        raise Unusable(f"{where}: {first_fault(error)}; correct it there.") from error


def check_values(fields: object, where: str) -> None:
    """Raises Unusable for a number that is not finite and for half a surrogate pair."""
    for place, _, value in _leaves(fields):
        if isinstance(value, float) and not math.isfinite(value):
            raise Unusable(
                f"{where}: {_plain(place)} is {value} (NaN, Infinity, or beyond 1.8e308); "
                "give a finite number there, or null where it is unknown."
            )
        beyond_ascii = isinstance(value, str) and not value.isascii()
        if beyond_ascii and any(category(sign) == "Cs" for sign in value):
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
    """Every value that contains no others, and every name, with its path and its nearest name."""
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
