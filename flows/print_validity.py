"""Prints the validity of a run."""

from typing import Any

from schemas.validity import RunVerdict, Validity

WORDS: dict[RunVerdict, str] = {
    "valid": "the run is valid",
    "remarks": "the run is valid with remarks, on which no unit passes",
    "invalid": "the run is invalid, and nothing is decided on the unit",
}


def summary(validity: Validity) -> dict[str, Any]:
    """The validity as in JSON."""
    return {"verdict": validity.verdict, "reasons": list(validity.reasons)}


def lines(validity: Validity) -> list[str]:
    """The validity, and a line for each reason."""
    return [WORDS[validity.verdict], *(f"  {reason}" for reason in validity.reasons)]
