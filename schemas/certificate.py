"""A certificate: client, unit, conditions and the result that it prints (JJF 2003, clause 8)."""

import re
from datetime import date
from typing import Literal, Self

from pydantic import AwareDatetime, Field, model_validator

from schemas.access import Authorised
from schemas.base import Frozen
from schemas.calibration import Calibration
from schemas.laboratory import EquipmentLimit, LimitName, MeasurementStandard, ResultAxes
from schemas.recording import Curve, Manifest
from schemas.station import Configuration, configuration_of
from schemas.text import BOTH, CONTRACTED, AnyMessage, Appearance, Language, Statement, Wording
from schemas.tolerance import Capability, Decision, Tolerance, check_apart

# The signature of an order that is given in a person's name, and the key of certificates.


class Signature(Frozen):
    """Who gave an order, when and where, protected against forgery.

    nonce: a number that is used once. signed_on: the login at the operating system and its
    computer, as `wang@station-2`. mac: HMAC-SHA256 by the key of the home over the flow's name, the
    order without its signature, and the other fields here, as canonical JSON.
    """

    person: str = Field(min_length=1)
    signed_at: AwareDatetime
    nonce: str = Field(pattern=r"^[0-9a-f]{32}$")
    signed_on: str
    mac: str = Field(pattern=r"^[0-9a-f]{64}$", repr=False)


class Token(Frozen):
    """A key in a PKCS#11 token (a card, an HSM, SoftHSM).

    module: the manufacturer's library. token: label of the token; key: label of the key and of its
    certificate.
    """

    module: str = Field(min_length=1)
    token: str = Field(min_length=1)
    key: str = Field(min_length=1)


class SigningSettings(Frozen):
    """The signing key: pkcs12, a file relative to the home folder unless absolute; or a token.

    The passphrase or PIN is taken from the environment (MIMUCAL_SIGNING_PASSPHRASE). time_stamps:
    address of a time-stamping service (RFC 3161), for the PDF.
    """

    pkcs12: str | None = None
    pkcs11: Token | None = None
    time_stamps: str | None = None

    @model_validator(mode="after")
    def _one_key(self) -> Self:
        if (self.pkcs12 is None) == (self.pkcs11 is None):
            raise ValueError("signing names one key: give either pkcs12 or pkcs11")
        return self


NUMBER = re.compile(r"\w[\w.-]{0,63}")  # it becomes a file name
DEFAULT_PREFIX = "MIMU"
DEFAULT_SCHEME = "{prefix}-{year}-{serial:04d}"
State = Literal["draft", "checked", "issued", "amended", "withdrawn"]
LIVE: tuple[State, ...] = ("draft", "checked", "issued")  # valid, or may become valid
INVALID_RUN = "invalid-run"  # ends the purpose of a report of an invalid run
StepName = Literal["draft", "check", "issue"]
# Conditions of a specification without which no unit passes, unless the client waives them.
ConditionName = Literal["largest_rate", "environment"]


class Party(Frozen):
    """A laboratory or a client."""

    name: str
    name_zh: str
    address: str
    address_zh: str


class Contact(Frozen):
    """Contact details of a laboratory beside its address."""

    e_mail: str | None = None
    phone: str | None = None
    web: str | None = None


class Laboratory(Frozen):
    """Clause 8 b), h), k), l): the laboratory, its standards and signatories (a file in the home).

    accreditation: body and number, as it may be claimed for these results. place: where it
    calibrates, if not at its address. limits: error limits of its equipment, in place of Table 1 of
    the specification. capabilities: its CMC: no smaller U is decided on or printed, and the
    accreditation is printed only where they cover every item. latitude_deg: of its site, compared
    with that of each recording. number_scheme: how {prefix}, {year} of issue and {serial} form the
    number of a certificate. separate_persons: whether drafting, checking and issuing a certificate
    require three different persons. language: of its printed certificates. wording: its own texts
    for labels of the certificate, by label name. logo, seal, template: its files, relative to the
    home folder unless absolute; their content becomes appearance. signing: the key that signs
    issued certificates. The record of a certificate does not contain the paths of these files.
    authorised: who may acquire, check and issue; where anybody is named, nobody else may. operator:
    who acquires and drafts where nobody is named. equipment: the measurement standards of
    recordings that name none; what it says of a standard that a recording names must agree.
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
    language: Language = BOTH
    equipment: tuple[MeasurementStandard, ...] = ()
    limits: dict[LimitName, EquipmentLimit] = Field(default_factory=dict)
    capabilities: tuple[Capability, ...] = ()
    latitude_deg: float | None = Field(default=None, ge=-90, le=90)
    wording: dict[str, Wording] = Field(default_factory=dict)
    logo: str | None = Field(default=None, exclude=True)
    seal: str | None = Field(default=None, exclude=True)
    template: str | None = Field(default=None, exclude=True)
    appearance: Appearance | None = None
    signing: SigningSettings | None = Field(default=None, exclude=True)
    authorised: tuple[Authorised, ...] = Field(default=(), exclude=True)
    operator: str | None = None
    checker: str | None = None
    issuer: str | None = None
    issuer_title: str | None = None
    issuer_title_zh: str | None = None

    @model_validator(mode="after")
    def _capabilities_do_not_overlap(self) -> Self:
        check_apart(self.capabilities)
        return self

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
    """Clause 8 e), g) and 9: the client, the date of receipt, the recalibration interval.

    calibrated_on: for a recording without a date of its own. recalibration_agreed: whether the
    client agreed to a recalibration date on the certificate (ISO/IEC 17025, 7.8.4.3): after
    interval_months, or as the specification states (12 months in JJF 2003, 24 in JJF 1536). An
    order that states the interval agrees to it. conformity: whether a statement of conformity is
    asked for; without one, no verdict is given. waived_conditions: conditions that need not be met
    or checked for a pass. configuration: of the unit, in addition to the recording's manifest.
    place: of calibration, if not the laboratory's own. language: of the certificate, if not the
    laboratory's. axes: about which the results are: those of the unit's mounting plane (its base),
    those of the fixture, or those of the unit as the recording's mount states them in the fixture;
    where nothing is said, those of the mounting plane if the laboratory states the limit
    `mounting`, else those of the unit, which are the fixture's where the mount is square.
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
    language: Language | None = None
    axes: ResultAxes | None = None

    @property
    def agrees_on_recalibration(self) -> bool:
        """Whether the certificate states a recalibration date."""
        return self.recalibration_agreed or self.interval_months is not None


class AsFound(Frozen):
    """The same unit before adjustment: its result, and the verdict by the same limits."""

    calibrated_on: date | None
    calibration: Calibration
    decision: Decision


class Step(Frozen):
    """Who drafted, checked or issued a certificate, and when. title: of the person, at the time."""

    step: StepName
    person: str = Field(min_length=1)
    at: AwareDatetime
    reason: str | None = None
    title: str | None = None
    title_zh: str | None = None


class Amended(Frozen):
    """A difference from the certificate that it replaces: before, and now."""

    what: Statement
    before: Statement
    after: Statement


class Replaced(Frozen):
    """The certificate that an amendment replaces, the reason, and everything that is different."""

    number: str
    issued_on: date
    why: str = Field(min_length=1)
    changes: tuple[Amended, ...] = ()


class Certificate(Frozen):
    """Everything the certificate prints; the PDF is made from this record alone.

    calibrated_on: null if no day is given; `due` then counts from `issued_on`. due: null if no
    recalibration was agreed. as_found: given if the unit was adjusted; calibration and decision are
    then those as left. budgets: whether the uncertainty budgets of the calibration are printed.
    tolerance: the limits of the decision. operator: who carried out the measurement, where the
    manifest does not say it. report: the agreement with the client by which this is a report of
    less than a certificate states (ISO/IEC 17025, 7.8.1.3); null for a certificate.
    validation: which record validates the estimation, and how many items (English, Chinese).
    number: by the laboratory's scheme once issued; before that, the key of the draft. curves: the
    content of its figures. evidence_sha256: of the file with what every value rests on, which lies
    beside the certificate; null where the result has none. steps: in order. state: after the last
    step; whether an issued certificate was amended or withdrawn is kept in the catalogue.
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
    tolerance: Tolerance | None = None
    operator: str | None = None
    report: str | None = None
    as_found: AsFound | None = None
    budgets: bool = False
    validation: tuple[str, str] | None = None
    validation_message: AnyMessage = None
    curves: tuple[Curve, ...] = ()
    evidence_sha256: str | None = None
    steps: tuple[Step, ...] = ()
    replaces: Replaced | None = None

    @property
    def configuration(self) -> Configuration:
        """The configuration of the unit, by the manifest and the order."""
        ordered = self.order.configuration if self.order else None
        return configuration_of(self.manifest.unit, ordered)

    @property
    def carried_out_by(self) -> str | None:
        """Who carried out the measurement, as the station recorded it, else as it was stated."""
        recorded = (self.manifest.model_extra or {}).get("operator")
        return recorded if isinstance(recorded, str) and recorded.strip() else self.operator

    @property
    def languages(self) -> tuple[str, ...]:
        """The languages of the certificate, the main one first: by the order, else by the
        laboratory.
        """
        ordered = self.order.language if self.order else None
        language = ordered or (self.laboratory.language if self.laboratory else BOTH)
        return CONTRACTED[::-1] if language == BOTH else (language,)

    @property
    def purpose(self) -> str:
        """The purpose of the certificate: of one run and purpose only one certificate is valid at a
        time.
        """
        calibration = self.calibration
        words = [calibration.method, *(term.name for term in calibration.terms)]
        if self.as_found is not None:
            words.append("as-left")
        if calibration.validity.verdict == "invalid":
            words.append(INVALID_RUN)
        return " ".join(words)

    def step(self, name: StepName) -> Step | None:
        """The last such step; None if nobody has taken it."""
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
