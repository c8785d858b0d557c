"""The files that an order names: limits, laboratory, client's order, procedure."""

from datetime import date
from pathlib import Path

from schemas.procedure import Procedure
from storage import settings
from tasks.stages.papers import Papers
from tasks.station import procedures


def read_papers(
    tolerance: str | None,
    laboratory: str | None,
    order: str | None,
    calibrated_on: date | None,
    budget: bool = False,
) -> Papers:
    """Read the named files. Raises Unusable for a bad one, before anything turns."""
    return Papers(
        settings.read_tolerance(Path(tolerance)) if tolerance else None,
        settings.read_laboratory(Path(laboratory)) if laboratory else None,
        settings.read_order(Path(order)) if order else None,
        calibrated_on,
        budget,
    )


def read_procedure(name: str) -> Procedure:
    """A procedure by its name, or from a file where the name is that of a file."""
    if Path(name).suffix in (".toml", ".json"):
        return settings.read_procedure(Path(name))
    return procedures.load(name)
