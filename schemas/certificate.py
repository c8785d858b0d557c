"""A certificate: client, unit, conditions and the result that it prints (JJF 2003, clause 8)."""

import re
from datetime import date
from typing import Literal, Self

from pydantic import AwareDatetime, Field, model_validator

from schemas.appearance import Appearance, Wording
from schemas.base import Frozen
from schemas.calibration import Calibration
from schemas.configuration import Configuration, configuration_of
from schemas.curve import Curve
from schemas.decision import Decision
from schemas.equipment import EquipmentLimit, LimitName, MeasurementStandard
from schemas.recording import Manifest
from schemas.signing import SigningSettings

NUMBER = re.compile(r"\w[\w.-]{0,63}")  # it becomes a file name
DEFAULT_PREFIX = "MIMU"
DEFAULT_SCHEME = "{prefix}-{year}-{serial:04d}"
State = Literal["draft", "checked", "issued", "amended", "withdrawn"]
LIVE: tuple[State, ...] = ("draft", "checked", "issued")  # it counts, or may come to
INVALID_RUN = "invalid-run"  # ends the purpose of a report of an invalid run
StepName = Literal["draft", "check", "issue"]
PrintedIn = Literal["zh", "en", "both"]
PRINTED_IN: dict[PrintedIn, tuple[str, ...]] = {  # the large one first
    "zh": ("zh",),
    "en": ("en",),
    "both": ("zh", "en"),
}
# Conditions of a specification without which no unit passes, unless the client waives them.
ConditionName = Literal["largest_rate", "environment"]


class Party(Frozen):
    """A laboratory or a client."""

    name: str
    name_zh: str
    address: str
    address_zh: str


class Contact(Frozen):
    """How a laboratory is reached beside its address."""

    e_mail: str | None = None
    phone: str | None = None
    web: str | None = None


class Laboratory(Frozen):
    """Clause 8 b), h), k), l): the laboratory, its standards, who signs (a file in the home).

    accreditation: by whom and under which number, as it may be claimed for these results. place:
    where it calibrates, if that is not its address.
    limits: what its equipment may be off by, in the place of Table 1 of the specification.
    latitude_deg: of its own place, against which that of each recording is held. number_scheme:
    how {prefix}, {year} of issue and {serial} make the number of a certificate. separate_persons:
    whether who drafts, who checks and who issues a certificate have to be three persons.
    language: in which its certificates are printed. wording: labels of the certificate in its own
    words, by their names. logo, seal, template: its files, from the home's folder where they are
    not absolute; what they hold becomes appearance. signing: the key that signs what is issued.
    No record of a certificate tells where these files lie.
    """

    format: Literal["mimu-laboratory/1"] = "mimu-laboratory/1"
    party: Party
    contact: Contact = Contact()
    accreditation: str | None = None
    accreditation_zh: str | None = None
    place: str | None = None
    place_zh: str | None = None
    certificate_prefix: str = DEFAULT_PREFIX
    number_scheme: str = DEFAULT_SCHEME
    separate_persons: bool = True
    language: PrintedIn = "both"
    equipment: tuple[MeasurementStandard, ...] = ()
    limits: dict[LimitName, EquipmentLimit] = Field(default_factory=dict)
    latitude_deg: float | None = Field(default=None, ge=-90, le=90)
    wording: dict[str, Wording] = Field(default_factory=dict)
    logo: str | None = Field(default=None, exclude=True)
    seal: str | None = Field(default=None, exclude=True)
    template: str | None = Field(default=None, exclude=True)
    appearance: Appearance | None = None
    signing: SigningSettings | None = Field(default=None, exclude=True)
    operator: str | None = None
    checker: str | None = None
    issuer: str | None = None
    issuer_title: str | None = None
    issuer_title_zh: str | None = None

    @model_validator(mode="after")
    def _scheme_gives_names_of_files(self) -> Self:
        try:
            one, other = (
                self.number_scheme.format(prefix=self.certificate_prefix, year=2026, serial=serial)
                for serial in (1, 2)
            )
        except (ValueError, LookupError, AttributeError) as error:
            raise ValueError(
                f"number_scheme {self.number_scheme!r} is not understood; use {{prefix}}, {{year}} "
                "and {serial:04d}"
            ) from error
        if one == other:
            raise ValueError(f"number_scheme {self.number_scheme!r} lacks {{serial:04d}}")
        if not NUMBER.fullmatch(one):
            raise ValueError(
                f"certificate_prefix and number_scheme give the number {one!r}, which becomes a "
                "file name: use letters, digits, dots, hyphens and underscores"
            )
        return self


class Order(Frozen):
    """Clause 8 e), g) and 9: the client, when the unit came, how often it comes back.

    calibrated_on: for a recording that does not say when it was made. recalibration_agreed: whether
    the client agreed that the certificate says when the unit comes back (ISO/IEC 17025, 7.8.4.3):
    after interval_months, or as the specification has it (12 months in JJF 2003, 24 in JJF 1536).
    An order that states the interval agrees on it. conformity: whether a
    statement of conformity is asked for; without one the unit is calibrated and nothing decided.
    waived_conditions: those that need not be met or checked for a pass. configuration: of the unit,
    beside what the recording's manifest says of it. place: where it is calibrated, if that is not
    the laboratory's own place. language: of the certificate, if not the laboratory's.
    """

    format: Literal["mimu-order/1"] = "mimu-order/1"
    client: Party
    received: date
    calibrated_on: date | None = None
    recalibration_agreed: bool = False
    interval_months: int | None = Field(default=None, gt=0, le=120)
    conformity: bool = True
    waived_conditions: tuple[ConditionName, ...] = ()
    configuration: Configuration = Configuration()
    place: str | None = None
    place_zh: str | None = None
    language: PrintedIn | None = None

    @property
    def agrees_on_recalibration(self) -> bool:
        """Whether the certificate has a date of recalibration."""
        return self.recalibration_agreed or self.interval_months is not None


class AsFound(Frozen):
    """The same unit before it was adjusted: its result, and the verdict by the same limits."""

    calibrated_on: date | None
    calibration: Calibration
    decision: Decision


class Step(Frozen):
    """Who drafted, checked or issued a certificate, and when."""

    step: StepName
    person: str = Field(min_length=1)
    at: AwareDatetime
    reason: str | None = None


class Replaced(Frozen):
    """The certificate that an amendment takes the place of, and why."""

    number: str
    issued_on: date
    why: str = Field(min_length=1)


class Certificate(Frozen):
    """Everything the certificate prints; the PDF is made from this and nothing else.

    calibrated_on: null where nothing gives the day; `due` then counts from `issued_on`. due: null
    where no recalibration was agreed on.
    as_found: where the unit was adjusted, and calibration and decision are those as left.
    budgets: whether the uncertainty budgets of the calibration are printed. validation: which
    record validates the estimation, and how many items (English, Chinese). number: of the
    laboratory's scheme from its issue on; before, the key of the draft. curves: what its figures
    show. steps: in their order.
    state: at the last of them; that an issued one was amended or withdrawn stands in the catalogue.
    """

    format: Literal["mimu-certificate-record/1"] = "mimu-certificate-record/1"
    number: str
    state: State
    calibrated_on: date | None
    issued_on: date
    due: date | None
    laboratory: Laboratory | None
    order: Order | None
    manifest: Manifest
    calibration: Calibration
    decision: Decision
    as_found: AsFound | None = None
    budgets: bool = False
    validation: tuple[str, str] | None = None
    curves: tuple[Curve, ...] = ()
    steps: tuple[Step, ...] = ()
    replaces: Replaced | None = None

    @property
    def configuration(self) -> Configuration:
        """How the unit was set up, by the manifest and the order."""
        ordered = self.order.configuration if self.order else None
        return configuration_of(self.manifest.unit, ordered)

    @property
    def languages(self) -> tuple[str, ...]:
        """In which it is printed, the large one first: as the order says, else the laboratory."""
        ordered = self.order.language if self.order else None
        usual = self.laboratory.language if self.laboratory else "both"
        return PRINTED_IN[ordered or usual]

    @property
    def purpose(self) -> str:
        """What it is made for: of one run and purpose only one certificate is valid at a time."""
        calibration = self.calibration
        words = [calibration.method, *(term.name for term in calibration.terms)]
        if self.as_found is not None:
            words.append("as-left")
        if calibration.validity.verdict == "invalid":
            words.append(INVALID_RUN)
        return " ".join(words)

    def step(self, name: StepName) -> Step | None:
        """Who took a step last; None where nobody has."""
        return next((step for step in reversed(self.steps) if step.step == name), None)

    @model_validator(mode="after")
    def _received_before_it_was_calibrated(self) -> Self:
        day, order = self.calibrated_on, self.order
        if day and order and order.received > day:
            raise ValueError(
                f"the order says received = {order.received}, which is after the calibration of "
                f"{day}: correct the order"
            )
        return self
