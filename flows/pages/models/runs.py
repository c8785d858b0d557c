"""The runs of the store as a list that can be filtered and sorted."""

from datetime import date

from pydantic import Field

from schemas.base import Frozen
from schemas.certificate import State
from schemas.decision import Verdict
from schemas.text import RunVerdict
from storage.catalogue.run_states import ResultState, RunLine

AT_ONCE = 100
MOST_AT_ONCE = 1000


class RunsQuestion(Frozen):
    """Which rows of the list: `count` of them after the first `start`.

    sort: a column of the rows; since, until: days of the recording, both included. The others
    are what a column must be equal to, without regard to case.
    """

    start: int = Field(default=0, ge=0, le=2**31)
    count: int = Field(default=AT_ONCE, ge=0, le=MOST_AT_ONCE)
    sort: str = Field(default="imported_at", max_length=40)
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


class RunsShown(Frozen):
    """Rows of the list, and how many runs meet the question in all."""

    total: int
    runs: tuple[RunLine, ...]
