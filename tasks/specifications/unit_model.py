"""The errors of the equipment of a run, for a unit as a clause found it."""

from collections.abc import Mapping

import numpy as np

from schemas.recording import AXES
from tasks.model.term import Term, nominal_values
from tasks.model.terms.site import earth_rotation
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.whole import Motion
from tasks.specifications.equipment_errors import equipment_errors
from tasks.specifications.error_sources import EquipmentErrors
from tasks.specifications.estimate import Estimates
from tasks.specifications.evidence import ClauseEvidence
from tasks.uncertainty.equipment import Equipment

UNKNOWN_LATITUDE_DEG = 45.0  # where it is only asked what tilts do to Earth's rotation


def errors_of_unit(
    evidence: ClauseEvidence,
    motion: Motion,
    equipment: Equipment,
    found: Mapping[str, Estimates] | None = None,
) -> EquipmentErrors:
    """The errors for models (1) and (2) of a unit.

    found: its estimates by term, in SI units; an ideal unit where they are not determined.
    """
    latitude_deg = evidence.latitude_deg
    phi = np.radians(UNKNOWN_LATITUDE_DEG if latitude_deg is None else latitude_deg)

    def terms_at(off: float) -> tuple[Term, ...]:
        return (earth_rotation(float(phi) + off), *STANDARD_TERMS)

    return equipment_errors(evidence, motion, terms_at, _values(found or {}), equipment)


def _values(found: Mapping[str, Estimates]) -> np.ndarray:
    """(p,) of the standard's terms."""
    values = nominal_values(STANDARD_TERMS)
    names = [
        (term.name, parameter.name) for term in STANDARD_TERMS for parameter in term.parameters
    ]
    for p, (term, element) in enumerate(names):
        estimate = found.get(term, {}).get(element)
        if estimate is not None and estimate.determined:
            values[p] = estimate.value
    return values


def doubled(elements: Estimates) -> Estimates:
    """The elements x, y, z of a matrix's diagonal as xx, yy, zz."""
    return {e * 2 if e in AXES else e: estimate for e, estimate in elements.items()}
