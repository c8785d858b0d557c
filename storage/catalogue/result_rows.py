"""The content of every result and certificate as rows, so that queries open no documents.

They are made of the documents alone, and can be made again from them.
"""

from datetime import datetime
from typing import Any

import sqlalchemy as sql

from schemas.calibration import Calibration
from schemas.decision import Decision
from storage.catalogue import database, tables


def add(
    connection: sql.Connection, result: str, calibration: Calibration, made_at: datetime
) -> None:
    """Adds the rows of a result; existing ones stay."""
    for table, rows in (
        (tables.elements, elements_of(calibration)),
        (tables.segments, segments_of(calibration)),
        (tables.outcomes, [outcome_of(calibration) | {"made_at": made_at}]),
    ):
        database.add_all_new(connection, table, [{"result": result} | row for row in rows])


def outcome_of(calibration: Calibration) -> dict[str, Any]:
    """Terms beside the standard's, validity of the run, and how many elements have no value."""
    values = [value for item in calibration.items.values() for value in item.value.values()]
    return {
        "run": calibration.run,
        "method": calibration.method,
        "terms": " ".join(term.name for term in calibration.terms),
        "verdict": calibration.validity.verdict,
        "missing": values.count(None),
    }


def elements_of(calibration: Calibration) -> list[dict[str, Any]]:
    """A row for each element of each item."""
    return [
        {"item": name, "element": element, "value": value}
        | {"u": item.u.get(element), "expanded": item.U.get(element)}
        | {"k": item.k, "unit": item.unit}
        for name, item in calibration.items.items()
        for element, value in item.value.items()
    ]


def segments_of(calibration: Calibration) -> list[dict[str, Any]]:
    """A row for each segment that was used, with the mean and deviation of each channel."""
    return [
        {"number": number}
        | segment.model_dump(exclude={"mean", "deviation"})
        | {f"mean_{name}": segment.mean.get(name) for name in tables.CHANNELS}
        | {f"deviation_{name}": segment.deviation.get(name) for name in tables.CHANNELS}
        for number, segment in enumerate(calibration.segments)
    ]


def add_decision(connection: sql.Connection, certificate: str, decision: Decision) -> None:
    """Adds the rows of what a certificate decides; those that are there stay."""
    rows = [{"certificate": certificate} | row for row in decisions_of(decision)]
    database.add_all_new(connection, tables.decisions, rows)


def decisions_of(decision: Decision) -> list[dict[str, Any]]:
    """A row for each limit on each element, in the order of the record."""
    names = ("item", "element", "applied_to", "lower", "upper", "verdict")
    return [
        {"number": number} | {name: getattr(limit, name) for name in names}
        for number, limit in enumerate(decision.limits)
    ]
