"""Stage: the result is held against the limits, and a certificate is made."""

from dataclasses import dataclass
from datetime import UTC, date, datetime
from pathlib import Path

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.certificate import Certificate, Laboratory, Order
from schemas.recording import Manifest
from schemas.station import Equipment
from schemas.tolerance import Tolerance
from storage import settings, store
from storage.home import Home
from storage.store import Run
from tasks import conformity, reminders
from tasks.certificate.pdf import render

DEFAULT_MONTHS = 12  # JJF 2003-2022, clause 9
DEFAULT_PREFIX = "MIMU"


@dataclass(frozen=True)
class Issued:
    """A certificate and where it lies."""

    certificate: Certificate
    pdf: Path
    record: Path


def certify(
    run: Run,
    calibration: Calibration,
    home: Home,
    *,
    tolerance: Tolerance | None = None,
    laboratory: Laboratory | None = None,
    order: Order | None = None,
) -> Issued:
    """Decide on the unit and publish a draft certificate; the due date enters the catalogue.

    Limits and laboratory come from the home where they are not given. The certificate stays a
    draft until persons have signed it.
    """
    manifest = store.load(run, home).manifest
    unit = manifest.unit
    if tolerance and (tolerance.manufacturer, tolerance.model) != (unit.manufacturer, unit.model):
        raise Unusable(
            f"the limits are those of {tolerance.manufacturer} {tolerance.model}, but run {run.id} "
            f"is of {unit.manufacturer} {unit.model}: give the limits of that model"
        )
    tolerance = tolerance or settings.tolerance_for(unit.manufacturer, unit.model, home)
    laboratory = laboratory or settings.laboratory(home)
    today = datetime.now(UTC).date()
    months = order.interval_months if order else DEFAULT_MONTHS
    calibrated_on = _calibrated_on(manifest, run)
    prefix = laboratory.certificate_prefix if laboratory else DEFAULT_PREFIX
    certificate = Certificate(
        number=store.reserve_number(home, prefix, today.year),
        state="draft",
        calibrated_on=calibrated_on,
        issued_on=today,
        due=reminders.due_date(calibrated_on, months),
        laboratory=_with_equipment(laboratory, manifest),
        order=order,
        manifest=manifest,
        calibration=calibration,
        decision=conformity.decide(calibration, tolerance),
    )
    pdf, record = store.save_certificate(certificate, render(certificate), home)
    return Issued(certificate, pdf, record)


def _calibrated_on(manifest: Manifest, run: Run) -> date:
    """The day the station recorded the run; of a recording that does not say, the day it came."""
    recorded_at = (manifest.model_extra or {}).get("recorded_at")
    try:
        return datetime.fromisoformat(str(recorded_at)).date()
    except ValueError:
        return run.taken_in_at.date()


def _with_equipment(laboratory: Laboratory | None, manifest: Manifest) -> Laboratory | None:
    """The laboratory with the station's own list of standards where it has none itself."""
    listed = (manifest.model_extra or {}).get("equipment", ())
    if laboratory is None or laboratory.equipment or not listed:
        return laboratory
    equipment = tuple(Equipment.model_validate(each) for each in listed)
    return laboratory.model_copy(update={"equipment": equipment})
