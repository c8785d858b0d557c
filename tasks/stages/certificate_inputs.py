"""Inputs of a certificate from outside the result, checked against the run."""

import base64
import json
from contextlib import suppress
from dataclasses import dataclass
from datetime import date, datetime, timedelta
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ValidationError

from schemas.base import Unusable, first_fault
from schemas.certificate import Laboratory, Order
from schemas.laboratory import MeasurementStandard
from schemas.orders import CertificateOptions
from schemas.recording import Unit
from schemas.text import Appearance
from schemas.tolerance import Tolerance
from storage import settings
from storage.catalogue.runs import Run
from storage.home import Home

DAY = timedelta(days=1)  # largest difference between the UTC date and the local date
LARGEST = 2_000_000  # bytes of a file, since every certificate contains it


@dataclass(frozen=True)
class CertificateInputs:
    """What a certificate needs beside the result; None where the home has to say, or nobody.

    calibrated_on: the day of calibration, for a recording that does not say when it was made.
    budget: whether the certificate prints the uncertainty budgets. invalid_run: whether a run that
    is invalid is reported all the same, without a verdict on any element. by: who drafts it.
    operator: who carried out the measurement, for a recording that does not say it. report: the
    agreement with the client by which it is a report of less than a certificate.
    """

    tolerance: Tolerance | None = None
    laboratory: Laboratory | None = None
    order: Order | None = None
    calibrated_on: date | None = None
    budget: bool = False
    invalid_run: bool = False
    by: str | None = None
    operator: str | None = None
    report: str | None = None


def _day_or_moment(stated: object) -> object:
    """A day or a moment in any form of ISO 8601 that imports know; anything else as it is."""
    for kind in (date, datetime) if isinstance(stated, str) else ():
        with suppress(ValueError):
            return kind.fromisoformat(str(stated))
    return stated


class ManifestFields(BaseModel):
    """The free fields of a manifest that a certificate prints."""

    recorded_at: Annotated[datetime | date | None, BeforeValidator(_day_or_moment)] = None
    acquired_at: Annotated[datetime | date | None, BeforeValidator(_day_or_moment)] = None
    equipment: tuple[MeasurementStandard, ...] = ()
    operator: str | None = None

    @property
    def moment(self) -> datetime | date | None:
        """When it was recorded, by the station's own clock; else when its first row was (UTC)."""
        return self.recorded_at or self.acquired_at


def read_inputs(options: CertificateOptions) -> CertificateInputs:
    """Reads the files that an order names; raises Unusable for a bad one."""
    return CertificateInputs(
        _read(options.tolerance, Tolerance),
        _read(options.laboratory, Laboratory),
        options.client_order
        if isinstance(options.client_order, Order)
        else _read(options.client_order, Order),
        options.calibrated_on,
        options.budget,
        options.invalid_run,
        options.by,
        options.operator,
        options.report,
    )


def _read(path: str | None, model: type[settings.Model]) -> settings.Model | None:
    return settings.read(Path(path), model) if path else None


def manifest_fields(extra: dict[str, object], run: Run) -> ManifestFields:
    """The free fields, read strictly: a number is no date."""
    try:
        return ManifestFields.model_validate_json(json.dumps(extra), strict=True)
    except ValidationError as error:
        raise Unusable(
            f"the manifest of run {run.id} ({run.recording_id}): {first_fault(error)}; correct it "
            "there and import the recording again"
        ) from error


def tolerance_of(inputs: CertificateInputs, run: Run, unit: Unit, home: Home) -> Tolerance | None:
    """The limits given, else those of the home; Unusable where they are of another model.

    None where the order asks for no statement of conformity.
    """
    given = inputs.tolerance
    if inputs.order and not inputs.order.conformity:
        return None
    if given is None:
        return settings.tolerance_for(unit.manufacturer, unit.model, home)
    if not settings.same_model(given, unit.manufacturer, unit.model):
        raise Unusable(
            f"the limits are those of {given.manufacturer} {given.model}, but run {run.id} "
            f"is of {unit.manufacturer} {unit.model}: give the limits of that model"
        )
    return given


def day_of_calibration(free: ManifestFields, inputs: CertificateInputs, run: Run) -> date | None:
    """The day the station recorded the run, by its own clock; else what the inputs say.

    A run that says only when its first row was, in UTC, leaves the local day open by one.
    """
    ordered = inputs.order.calibrated_on if inputs.order else None
    given = inputs.calibrated_on or ordered
    day = day_of(free.moment)
    if day and given and given != day:
        if not free.recorded_at and abs(given - day) <= DAY:
            return given
        stated = "recorded_at" if free.recorded_at else "acquired_at"
        raise Unusable(
            f"the calibration of run {run.id} is said to be of {given}, but its manifest says "
            f"{stated} = {day}: leave the day out"
        )
    return day or given


def operator_of(free: ManifestFields, inputs: CertificateInputs, run: Run) -> str | None:
    """Who carried out the measurement, where the recording does not say it.

    Raises Unusable where it does, and says another.
    """
    if free.operator and inputs.operator and inputs.operator != free.operator:
        raise Unusable(
            f"--operator names {inputs.operator}, but the manifest of run {run.id} says operator = "
            f"{free.operator}: leave the option out"
        )
    return None if free.operator else inputs.operator


def check_order(order: Order | None, calibrated_on: date | None, today: date) -> None:
    """Raises Unusable for an order that was received after the calibration, or after today."""
    if order and order.received > today:
        raise Unusable(
            f"the order says received = {order.received}, which is after today, {today}: correct "
            "the order"
        )
    if order and calibrated_on and order.received > calibrated_on:
        raise Unusable(
            f"the order says received = {order.received}, which is after the calibration of "
            f"{calibrated_on}: correct the order"
        )


def day_of_moment(now: datetime) -> date:
    """The day of a moment where this program runs."""
    return now.astimezone().date()


def day_of(moment: datetime | date | None) -> date | None:
    """The day of a moment; a day is its own."""
    return moment.date() if isinstance(moment, datetime) else moment


def with_appearance(laboratory: Laboratory, home: Home) -> Laboratory:
    """The laboratory with the content of its files, if it names any.

    Raises Unusable for a file that cannot be read or is of the wrong kind.
    """
    named = {"logo": laboratory.logo, "seal": laboratory.seal, "template": laboratory.template}
    paths = {name: home.path / path for name, path in named.items() if path}
    if not paths:
        return laboratory
    held = {name: _held(name, path) for name, path in paths.items()}
    try:
        appearance = Appearance.model_validate(held)
    except ValidationError as error:
        raise Unusable(f"laboratory.toml: {first_fault(error)}.") from error
    return laboratory.model_copy(update={"appearance": appearance})


def _held(name: str, path: Path) -> str:
    """A layout as it stands, a picture in base64."""
    try:
        content = path.read_bytes()
        if len(content) > LARGEST:
            raise Unusable(
                f"laboratory.toml: {name} = {path} has {len(content):,} bytes, and every "
                f"certificate holds it: make it smaller than {LARGEST:,}."
            )
        return content.decode() if name == "template" else base64.b64encode(content).decode()
    except OSError as error:
        raise Unusable(
            f"laboratory.toml: {name} = {path} cannot be read ({error.strerror}); check that it "
            "exists and is readable."
        ) from error
    except UnicodeDecodeError as error:
        raise Unusable(f"laboratory.toml: {name} = {path} is not UTF-8; save it as UTF-8.") from (
            error
        )
