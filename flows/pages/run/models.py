"""One run in full: segments, items, certificates, log and lineage."""

from datetime import date, datetime

from pydantic import Field

from schemas.base import Finite, Frozen
from schemas.certificate import State
from schemas.decision import LimitDecision, Verdict
from schemas.recording import Axis, Kind, Up
from schemas.run_log import LogEntry
from schemas.text import Remark, RunVerdict, Statement
from schemas.uncertainty import Budget
from storage.catalogue.run_states import RunLine


class SignalsQuestion(Frozen):
    """A channel of a stream between two times (s); null: from the beginning, to the end.

    bins: into how many equal times it is divided where it has more than twice as many rows.
    """

    run: str = Field(min_length=1, max_length=200)
    stream: str = "imu"
    channel: str = "gyro_x"
    since: Finite | None = None
    until: Finite | None = None
    bins: int = Field(default=1000, ge=1, le=10_000)


class SignalsShown(Frozen):
    """Every row, or of each bin the smallest and largest value: no peak is lost.

    t: s, of the row or of the beginning of the bin; low, high: the same where every row is shown
    (`is_reduced` is false), null where a bin has no number. rows: how many are between the times.
    unit: of the channel. channels: those of each stream of the run.
    """

    run: str
    stream: str
    channel: str
    unit: str
    since: Finite
    until: Finite
    rows: int
    is_reduced: bool
    t: tuple[Finite, ...]
    low: tuple[Finite | None, ...]
    high: tuple[Finite | None, ...]
    channels: dict[str, tuple[str, ...]]


class BudgetQuestion(Frozen):
    """Which element of which item of which run."""

    run: str = Field(min_length=1, max_length=200)
    item: str = Field(min_length=1, max_length=100)
    element: str = Field(min_length=1, max_length=10)


class BudgetShown(Frozen):
    """A budget and what it is of. result: by its id."""

    run: str
    result: str
    title: Statement
    symbol: str
    budget: Budget


class RunQuestion(Frozen):
    """A run by its id, its digest or its recording's id."""

    id: str = Field(min_length=1, max_length=200)


class SegmentShown(Frozen):
    """A segment, and the remarks of the result that name it. rows: null where none used it."""

    name: str
    kind: Kind
    t_start: Finite
    t_end: Finite
    up: Up | None = None
    axis: Axis | None = None
    rate_deg_s: Finite | None = None
    rows: int | None = None
    rows_left_out: int | None = None
    remarks: tuple[Remark, ...] = ()


class LimitShown(Frozen):
    """A limit as the certificate prints it; margin: to the nearer limit, in U."""

    decision: LimitDecision
    text: str
    margin: Finite | None


class ElementShown(Frozen):
    """An element of an item. value_text, U_text: as printed, in units of 10^exponent."""

    item: str
    title: Statement
    element: str
    symbol: str
    unit: str
    value: Finite | None
    U: Finite | None
    k: Finite
    exponent: int
    value_text: str | None
    U_text: str | None
    limits: tuple[LimitShown, ...] = ()
    has_budget: bool = False


class CertificateShown(Frozen):
    """A certificate on which the run stands."""

    number: str
    state: State
    verdict: Verdict
    run: str
    result: str
    calibrated_on: date | None
    issued_on: date
    due: date | None
    supersedes: str | None
    why: str | None


class ResultShown(Frozen):
    """A result of the run; the newest is what no other supersedes."""

    id: str
    method: str
    code_version: str
    made_at: datetime
    supersedes: str | None
    why: str | None


class StandardUsed(Frozen):
    """A measurement standard, and the document that names it."""

    name: str
    serial: str
    certificate: str
    document: str


class RunShown(Frozen):
    """A run. validity: by the newest result, null without one; unavailable: items not determined.
    order: number of the order that it was measured for, and which of its measurements it is.
    undecided: why the certificate of `limits_of` decides on nothing, whatever its limits say.

    limits_of: the certificate whose decision stands beside the items; null where none prints the
    newest result. settings, results, sources and standards: the lineage up; certificates: down.
    """

    run: RunLine
    digest: str
    order: tuple[str, int] | None = None
    validity: RunVerdict | None
    reasons: tuple[Statement, ...]
    segments: tuple[SegmentShown, ...]
    elements: tuple[ElementShown, ...]
    unavailable: dict[str, Statement]
    limits_of: str | None
    undecided: tuple[Statement, ...] = ()
    certificates: tuple[CertificateShown, ...]
    log: tuple[LogEntry, ...]
    settings: dict[str, Finite | str | None]
    results: tuple[ResultShown, ...]
    sources: tuple[str, ...]
    standards: tuple[StandardUsed, ...]
