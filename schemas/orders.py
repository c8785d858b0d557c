"""Orders: typed models that the command line, the Prefect flows and a schedule share.

Files, folders and runs are plain text, so that an order can be written down in JSON or YAML:
counted from the working folder of whoever carries it out. `home`: the folder that holds
everything; null is the one that MIMUCAL_HOME names. Those of certificates are in
`certificate_orders`.
"""

from datetime import date
from pathlib import PurePath
from typing import Annotated, Any, Literal, Self, TypeVar

from pydantic import (
    AfterValidator,
    AwareDatetime,
    Field,
    ValidationError,
    field_validator,
    model_validator,
)

from schemas.base import Frozen, Unusable
from schemas.calibration import Exported, Method
from schemas.certificate import Order, Signature
from schemas.laboratory import ResultAxes
from schemas.recording import Unit
from schemas.text import Statement

UncertaintyName = Literal["gum", "montecarlo", "example"]


class OrderModel(Frozen):
    """What every order has."""

    home: str | None = None


class Estimation(OrderModel):
    """How a run is estimated.

    method: null is that of the specification for which the recording was made. terms: physics
    that `explain` found, by catalogue name, taken off the readings first; as a text, the names
    stand with commas between. axes: about which the results are, if the client's order does not
    say; null: those of the mounting plane where its limit is stated, else those of the unit by
    the mount that the recording states, which are the fixture's where it states none.
    """

    method: Method | None = None
    uncertainty: UncertaintyName = "gum"
    terms: tuple[str, ...] | None = None
    axes: ResultAxes | None = None

    @field_validator("terms", mode="before")
    @classmethod
    def _names(cls, given: Any) -> Any:
        """Each name once, in alphabetical order."""
        names = given.split(",") if isinstance(given, str) else given
        return names and tuple(sorted({str(name).strip() for name in names} - {""}))

    @model_validator(mode="after")
    def _terms_go_with_the_clauses(self) -> Self:
        if self.terms is not None and self.method == "joint":
            raise ValueError(
                "--terms goes with the clauses of the specification; the joint method has Earth's "
                "rotation in its own model: leave --method joint or --terms out"
            )
        if self.terms is not None and self.uncertainty != "gum":
            raise ValueError(
                "--terms carries the uncertainty of the terms by the law of propagation; leave "
                f"--uncertainty {self.uncertainty} out"
            )
        return self


class AcquireOrder(OrderModel):
    """A run from a station: a station file, or the id of one of the home's stations.

    procedure: a name, or a file. units: those mounted, in the order of the station's places; those
    of the station file unless given. attended: whether a person at the terminal, if there is one,
    may be asked to turn the unit over. resume: go on with the run that was interrupted last. by:
    who carries out the measurement; null means the operator in the laboratory's file. signature:
    what a flow wants to see of an order that names a person.
    """

    station: str
    procedure: str = "jjf2003"
    units: tuple[Unit, ...] = ()
    attended: bool = True
    resume: bool = False
    by: str | None = None
    signature: Signature | None = None


class CalibrateOrder(Estimation):
    """Every item that a run (an id, or the path of a recording) allows."""

    run: str


class ExplainOrder(OrderModel):
    """Which physics the model leaves out of a run.

    others: further runs of the same unit, which are explained together with it.
    out: folder of the report; none is written without it. calibration: the model's parameters, a
    result's id or a mimu-calibration/1 file; they are fitted unless it is given. simulated: a
    recording of the same run by another simulator, in place of the model's prediction.
    """

    run: str
    others: tuple[str, ...] = ()
    out: str | None = None
    calibration: str | None = None
    simulated: str | None = None


class ReviewOrder(OrderModel):
    """What many runs show together.

    paths: recordings, or folders of them, imported on the fly; without any, the runs of the store
    that the rest selects, as in `Selection`. out: folder of the answer; none is written without it.
    """

    paths: tuple[str, ...] = ()
    since: date | None = None
    until: date | None = None
    model: str | None = None
    serial: str | None = None
    station: str | None = None
    out: str | None = None


class NextOrder(OrderModel):
    """The recording that resolves what `explain` left open for some runs of a unit.

    effects: to be told apart, in place of what is open; one alone is told from none. minutes: that
    the station may take. base: a procedure, or its file, whose room, warm-up and settling are
    kept. out: the new procedure file. station: a station file; by default, what the run's own table
    has shown it can do.
    """

    runs: tuple[str, ...] = Field(min_length=1)
    effects: tuple[str, ...] = ()
    minutes: float = Field(default=15.0, gt=0)
    base: str | None = None
    out: str | None = None
    station: str | None = None


class SimulateOrder(OrderModel):
    """What a unit with a calibration would have read on a run's motion, as a new folder.

    calibration: a result's id or a mimu-calibration/1 file; the run's own unless it is given.
    """

    run: str
    out: str
    calibration: str | None = None


class ExportOrder(OrderModel):
    """The correction that a result gives, as text in a form, or the evidence that it rests on.

    calibration: as in `ApplyOrder`.
    """

    calibration: str
    form: Exported = Field(alias="as")


class ApplyOrder(OrderModel):
    """A run with its unit's errors taken off, as a new folder.

    calibration: a result's id, the id of a run that was calibrated, or a mimu-calibration/1 file.
    with_u: whether each corrected channel has a column with its standard uncertainty beside it.
    """

    calibration: str
    run: str
    out: str
    with_u: bool = False


class Selection(OrderModel):
    """Runs selected by their entries in the catalogue; null does not restrict.

    since, until: days of recording, both included (of import, where that is unknown). procedure:
    its name, or the standard. equipment: name, serial number or calibration certificate of a
    measurement standard, or the station. code_version: the beginning of that of a run's newest
    result.
    """

    since: date | None = None
    until: date | None = None
    model: str | None = None
    serial: str | None = None
    station: str | None = None
    procedure: str | None = None
    equipment: str | None = None
    code_version: str | None = None

    @model_validator(mode="after")
    def _not_backwards(self) -> Self:
        if self.since and self.until and self.since > self.until:
            raise ValueError(f"--since {self.since} is after --until {self.until}; swap them")
        return self


class ReprocessOrder(Selection):
    """The newest results of a selection of runs, made again with today's code.

    engine: processes on this machine, or the dask cluster whose scheduler is given. workers: how
    many processes; null is one for each processor. out: folder of the report. dry_run: only say
    what would be done.
    """

    engine: Literal["local", "dask"] = "local"
    scheduler: str | None = None
    workers: int | None = Field(default=None, ge=1)
    out: str | None = None
    dry_run: bool = False

    @model_validator(mode="after")
    def _dask_has_a_scheduler(self) -> Self:
        if (self.engine == "dask") != (self.scheduler is not None):
            raise ValueError(
                "--engine dask and --scheduler ADDRESS go together; give both or neither"
            )
        return self


class RemindOrder(OrderModel):
    """The units whose recalibration is due within so many days."""

    within_days: int = Field(default=30, ge=0)


class SubmitOrder(OrderModel):
    """Every production order that waits, given to Prefect once more."""


class AlertOrder(OrderModel):
    """A sentence to whoever operates the line."""

    sentence: str = Field(min_length=1)


AnyOrder = TypeVar("AnyOrder", bound=Frozen)


def order_of(kind: type[AnyOrder], **fields: Any) -> AnyOrder:
    """The order with these fields; raises Unusable, named by the option, for one that is wrong."""
    try:
        return kind(**fields)
    except ValidationError as error:
        raise Unusable(_sentence(error)) from error


def _sentence(error: ValidationError) -> str:
    fault = error.errors(include_url=False)[0]
    message = fault["msg"].removeprefix("Value error, ")
    if not fault["loc"]:
        return message
    if fault["type"] == "literal_error":
        expected = fault["ctx"]["expected"].replace("'", "").replace(" or ", ", ")
        message = f"choose one of {expected}"
    option = f"--{str(fault['loc'][0]).replace('_', '-')}"
    if fault["type"] == "string_too_short":
        return f"{option} is empty: give a text."
    return f"{option} {fault['input']}: {message}"


# Production orders: which unit is measured on which station, by which procedure, for whom.
#
# `OrderRequest` is what a person or a manufacturing system asks for, as JSON or as a row of a CSV
# file; `ProductionOrder` is the order as the catalogue keeps it, with what became of it.

# Visible characters, with spaces between them: what a label, a scanner or a form can give.
Name = Annotated[
    str, Field(min_length=1, max_length=100, pattern=r"^[^\p{C}\p{Z}]([^\p{C}]*[^\p{C}\p{Z}])?$")
]


def _is_serial(text: str) -> str:
    """Refuses markup, and what has neither letter nor digit, as dots."""
    if MARKUP & set(text) or not any(sign.isalnum() for sign in text):
        raise ValueError("a serial number has a letter or a digit, and none of < > & \" ' ` \\")
    return text


MARKUP = set("<>&\"'`\\")
Serial = Annotated[Name, AfterValidator(_is_serial)]
ProductionState = Literal["waiting", "running", "done", "failed", "cancelled"]
OPEN: tuple[ProductionState, ...] = ("waiting", "running")
ENDED: tuple[ProductionState, ...] = ("done", "failed", "cancelled")


class OrderedUnit(Frozen):
    """A unit by its serial number.

    manufacturer, model: null means those of the station file's unit at the same place.
    """

    serial: Serial
    manufacturer: Name | None = None
    model: Name | None = None


class OrderRequest(Frozen):
    """An order as submitted.

    number: by which the order is known; the same content under the same number is the same order.
    Null: one is generated. station: its id. units: those to be mounted, in the order of the
    station's places. procedure: a name, or a file of the station's computer. client_order: the
    client's order, which the certificate needs.
    """

    number: Name | None = None
    station: Name
    units: tuple[OrderedUnit, ...] = Field(min_length=1, max_length=64)
    procedure: str = Field(default="jjf2003", min_length=1, max_length=1000)
    client_order: Order | None = None


class RetriedOrder(Frozen):
    """An order that failed or was cancelled is to be carried out again, and why."""

    number: Name
    reason: str | None = Field(default=None, max_length=1000)


class ProductionOrder(Frozen):
    """An order of the catalogue, and what became of it.

    person: who ordered. is_interrupted: a run of it has begun and not ended; whoever takes it next
    goes on with that run. attempts: how often it was begun. submissions: how often it was given to
    Prefect; flow_run: the last of them, null where there is none that counts. host, process: where
    it was begun last. runs, certificates: ids and keys of drafts, in the order of the units. fault:
    why it failed; of one that waits, what keeps it from beginning; cause: the same for the pages.
    """

    number: str
    station: str
    units: tuple[Unit, ...]
    procedure: str
    client_order: Order | None = None
    person: str
    ordered_at: AwareDatetime
    state: ProductionState = "waiting"
    is_interrupted: bool = False
    attempts: int = 0
    submissions: int = 0
    flow_run: str | None = None
    host: str | None = None
    process: int | None = None
    began_at: AwareDatetime | None = None
    ended_at: AwareDatetime | None = None
    runs: tuple[str, ...] = ()
    certificates: tuple[str, ...] = ()
    fault: str | None = None
    cause: Statement | None = None

    @property
    def serials(self) -> str:
        """The serial numbers of its units, as they are shown."""
        return ", ".join(unit.serial for unit in self.units)

    @property
    def title(self) -> str:
        """Its units and its procedure, as its flow run is called."""
        return f"{self.serials} {PurePath(self.procedure).stem}"

    def differs_from(self, other: "ProductionOrder") -> str | None:
        """Names what another order asks for otherwise, whoever ordered and whenever."""
        for name in ("station", "units", "procedure", "client_order"):
            if getattr(self, name) != getattr(other, name):
                return name.replace("_", " ")
        return None


class ProductionOrders(Frozen):
    """Orders as the command line and the pages list them, the oldest first."""

    format: Literal["mimu-orders/1"] = "mimu-orders/1"
    orders: tuple[ProductionOrder, ...]


class GivenOrders(ProductionOrders):
    """Orders that were given. new: the numbers of those that were not there before. fault: why one
    of them cannot be carried out at present; it waits.
    """

    new: tuple[str, ...] = ()
    fault: str | None = None


class OrdersQuestion(Frozen):
    """Which orders are listed: those of a station, those in a state; null: all."""

    station: str | None = None
    state: ProductionState | None = None


class QualityFile(Frozen):
    """`quality.toml` of the home: what the laboratory says of its production.

    golden: serial numbers of units that are measured again and again to check the stations. They
    are not production: they are excluded from yield and capability.
    """

    format: Literal["mimu-quality/1"] = "mimu-quality/1"
    golden: tuple[str, ...] = ()


# Orders of certificates: drafted, checked, issued, amended, withdrawn (see `orders`).

Person = Annotated[str, Field(min_length=1, pattern=r"\S")]


class CertificateOptions(OrderModel):
    """Inputs of a certificate beside the result; null leaves the choice to the home.

    tolerance, laboratory and client_order are files; client_order, the client's order
    (`mimu-order/1`), may also stand here itself. calibrated_on: for a recording without a date of
    its own. as_found: the run (an id, or the path of a recording) of the unit before adjustment,
    whose results the certificate shows beside these. budget: whether the certificate prints the
    uncertainty budgets. invalid_run: whether to report an invalid run all the same. by: who drafts
    it; null means the operator in the laboratory's file. signature: what a flow wants to see of an
    order that names a person. operator: who carried out the measurement, for a recording that does
    not say it. report: the agreement with the client by which this is a report of less than a
    certificate states (ISO/IEC 17025:2017, 7.8.1.3); null for a certificate.
    """

    tolerance: str | None = None
    laboratory: str | None = None
    client_order: str | Order | None = None
    calibrated_on: date | None = None
    as_found: str | None = None
    budget: bool = False
    invalid_run: bool = False
    by: str | None = None
    operator: str | None = None
    report: str | None = Field(default=None, min_length=1, pattern=r"\S")
    signature: Signature | None = None


class CertifyOrder(CalibrateOrder, CertificateOptions):
    """The result, the verdict and the certificate of a run."""


class ProduceOrder(AcquireOrder, CertificateOptions):
    """A run from a station, and its certificate.

    number: of the production order in the catalogue, which then says what is measured for whom;
    null makes an order of its own, as for a schedule.
    """

    number: str | None = None

    def certify(self, run: str) -> CertifyOrder:
        """The order of the certificate, once the run exists; it is signed for its own flow."""
        shared = CertificateOptions.model_fields.keys() - {"signature"}
        return CertifyOrder(run=run, **{name: getattr(self, name) for name in shared})


class StepOrder(OrderModel):
    """A step that a person takes with a certificate (its number, or the key of its draft).

    signature: what a flow wants to see of it.
    """

    certificate: str
    by: Person
    signature: Signature | None = None


class CheckOrder(StepOrder):
    """A draft was checked."""

    reason: str | None = None


class IssueOrder(StepOrder):
    """A checked certificate is issued, and gets its number."""

    reason: str | None = None


class WithdrawOrder(StepOrder):
    """An issued certificate is withdrawn."""

    why: str = Field(min_length=1)


class AmendOrder(StepOrder, CertificateOptions):
    """A draft that is to replace an issued certificate.

    run: on which it is based, by default that of the certificate. Options that are not given are
    taken from the certificate, its limits among them.
    """

    by: Person
    why: str = Field(min_length=1)
    run: str | None = None
