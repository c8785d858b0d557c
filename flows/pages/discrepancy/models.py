"""Which effects many runs show, by the last review and by each run's own findings."""

from datetime import date

from pydantic import AwareDatetime, Field

from schemas.base import Finite, Frozen
from schemas.discrepancy import FoundParameter, Moved, Verdict
from schemas.review import ReviewFinding
from schemas.text import RunVerdict, Statement


class DiscrepancyQuestion(Frozen):
    """Which of the explained runs. Null: all of them. The review is the last one in any case."""

    effect: str | None = Field(default=None, max_length=200)
    station: str | None = Field(default=None, max_length=200)
    model: str | None = Field(default=None, max_length=200)
    serial: str | None = Field(default=None, max_length=200)


class Papers(Frozen):
    """The certificates on runs that an effect touches. numbers: of issued ones, the newest first,
    so many of them as are listed; issued and drafts: how many there are of either.
    """

    issued: int = 0
    drafts: int = 0
    numbers: tuple[str, ...] = ()


class UncertainTime(Frozen):
    """The days in which an effect may have been there already, or still. query: the fields of the
    list of runs that name the carrier's runs of that time; papers: certificates on these.
    """

    query: dict[str, str]
    papers: Papers


class PaperMoved(Frozen):
    """A certificate on a reviewed run, and its elements that the effect moves, the most first."""

    number: str
    run: str
    moved: tuple[Moved, ...]


class Carried(Frozen):
    """What a review found. query: the fields of the list of runs that name the carrier's runs; null
    where the catalogue does not tell them. papers: certificates on these. moved: those of reviewed
    runs with what it changes in them, the most first.
    """

    title: Statement
    finding: ReviewFinding
    query: dict[str, str] | None
    papers: Papers | None
    uncertain: tuple[UncertainTime, ...]
    moved: tuple[PaperMoved, ...]


class ReviewShown(Frozen):
    """The last review. asked: what it was asked of; skipped: runs that it could not use."""

    at: AwareDatetime
    asked: dict[str, str]
    days: tuple[date, date] | None
    runs: int
    skipped: int
    verdict: Verdict
    statement: Statement
    findings: tuple[Carried, ...]


class Shown(Frozen):
    """In how many of its explained runs a station, unit or model shows an effect.

    model: of a unit.
    """

    name: str
    model: str | None = None
    shown: int
    of: int
    since: date | None


class EffectSeen(Frozen):
    """An effect that `explain` named in runs. since, until: the days of its first and last run.

    moved: the elements that it moves most, in the run that it moves most.
    """

    effect: str
    title: Statement
    runs: int
    since: date | None
    until: date | None
    by_station: tuple[Shown, ...]
    by_model: tuple[Shown, ...]
    by_unit: tuple[Shown, ...]
    moved: tuple[Moved, ...]
    papers: Papers


class FoundShown(Frozen):
    """A finding in one run."""

    effect: str
    title: Statement
    share: Finite
    parameters: tuple[FoundParameter, ...]
    others: tuple[str, ...]


class ExplainedRun(Frozen):
    """A run that was explained, with what was found in it."""

    run: str
    day: date | None
    station: str
    model: str
    serial: str
    validity: RunVerdict | None = None
    verdict: Verdict
    findings: tuple[FoundShown, ...]


class DiscrepancyShown(Frozen):
    """review: null where none was made. runs: how many there are; explained: how many of these were
    explained and are asked for; invalid: of these the runs that are invalid, whose findings count
    for no effect; newest: the last ones. stations, models, serials, effects: what may be asked for.
    """

    review: ReviewShown | None
    runs: int
    explained: int
    invalid: int = 0
    effects: tuple[EffectSeen, ...]
    newest: tuple[ExplainedRun, ...]
    stations: tuple[str, ...]
    models: tuple[str, ...]
    serials: tuple[str, ...]
    known: tuple[str, ...]
