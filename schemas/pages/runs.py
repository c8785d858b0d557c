"""The runs of the store as a list that can be filtered and sorted."""

from datetime import date, datetime
from typing import Literal

from pydantic import Field

from schemas.base import Finite, Frozen
from schemas.certificate import State
from schemas.decision import Verdict
from schemas.text import RunVerdict

AT_ONCE = 100
MOST_AT_ONCE = 1000
ResultState = Literal["whole", "partial", "missing", "failed"]
Comparison = Literal[
    "contains", "not_contains", "begins", "ends", "equals", "not_equals", "blank", "not_blank",
    "less", "less_or_equal", "greater", "greater_or_equal", "between", "among",
]  # fmt: skip


class Condition(Frozen):
    """What a column must meet. `to`: the end of `between`; values: those of `among`.

    any_of, all_of: other conditions on the column, of which one or all must be met in its place.
    """

    column: str
    kind: Comparison = "equals"
    value: date | Finite | str | None = None
    to: date | Finite | None = None
    values: tuple[str | None, ...] = ()
    any_of: tuple["Condition", ...] = ()
    all_of: tuple["Condition", ...] = ()


class RunsQuestion(Frozen):
    """Which rows of the list: `count` of them after the first `start`.

    sort: a column of the rows; since, until: days of the recording, both included. The others
    are what a column must be equal to, without regard to case.
    """

    start: int = Field(default=0, ge=0, le=2**31)
    count: int = Field(default=AT_ONCE, ge=0, le=MOST_AT_ONCE)
    sort: str = Field(default="taken_in_at", max_length=40)
    descending: bool = True
    since: date | None = None
    until: date | None = None
    id: str | None = None
    manufacturer: str | None = None
    model: str | None = None
    serial: str | None = None
    station: str | None = None
    procedure: str | None = None
    method: str | None = None
    validity: RunVerdict | None = None
    result_state: ResultState | None = None
    state: State | None = None
    verdict: Verdict | None = None
    certificate: str | None = None


class RunLine(Frozen):
    """A run with the state of its steps; null: that step was not taken.

    unit: the unit's number in the catalogue. result, method, made_at: the result made last;
    validity: its verdict on the run; missing: how many elements it could not determine. fault: why
    the last re-processing failed. result_state: partial where elements are missing, failed where
    there is a fault. certificate (a draft's key before its issue), state, verdict,
    due: of the certificate kept last.
    """

    id: str
    recording_id: str
    unit: int
    manufacturer: str
    model: str
    serial: str
    station: str | None
    procedure: str | None
    standard: str
    recorded_on: date | None
    taken_in_at: datetime
    seconds: float
    result: str | None
    method: str | None
    made_at: datetime | None
    validity: RunVerdict | None
    missing: int | None
    fault: str | None
    result_state: ResultState
    certificate: str | None
    state: State | None
    verdict: Verdict | None
    due: date | None


class RunsShown(Frozen):
    """Rows of the list, and how many runs meet the question in all."""

    total: int
    runs: tuple[RunLine, ...]
