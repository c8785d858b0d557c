"""Reads one run from the store, by the functions that the reports use."""

from collections.abc import Iterator, Sequence
from datetime import date, datetime
from functools import partial

import sqlalchemy as sql
from pydantic import Field, TypeAdapter, ValidationError

from flows.pages.parts import place
from schemas.base import Finite, Frozen, Unusable
from schemas.calibration import Budget, Calibration, SegmentUsed
from schemas.certificate import State
from schemas.recording import Axis, Kind, LogEntry, Manifest, Segment, Up
from schemas.text import Remark, RunVerdict, Statement, texts_of
from schemas.tolerance import LimitDecision, Verdict
from storage.catalogue import certificates, database, orders, results, runs, tables
from storage.catalogue.certificates import Entry, record_of
from storage.catalogue.run_states import Condition, RunLine, run_list
from storage.catalogue.runs import find
from storage.home import Home
from tasks.conformity.limits import limits_text
from tasks.specifications.estimate import item_title, symbol
from tasks.words import statement
from tasks.words.numbers import column

# One run in full: segments, items, certificates, log and lineage.


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


def data(question: RunQuestion, home: Home) -> RunShown:
    """A run with everything that the catalogue says of it; its recording is not opened."""
    run = find(question.id, home)
    _, (line,) = run_list([Condition(column="id", value=run.id)], [], 0, 1, home)
    manifest = runs.manifest(run, home)
    kept, entries = results.of_run(run, home), certificates.of_run(run, home)
    newest = results.newest(kept)
    made = newest.calibration if newest else None
    printing = next((e for e in reversed(entries) if newest and e.result == newest.id), None)
    validity = made.validity if made else None
    decision = record_of(printing, home).decision if printing else None
    return RunShown(
        run=line,
        digest=run.digest,
        order=orders.measured_for(run.id, home),
        validity=validity.verdict if validity else None,
        reasons=texts_of(validity, "reasons") if validity else (),
        segments=tuple(_segments(manifest, made)),
        elements=tuple(_elements(made, decision.limits if decision else ())) if made else (),
        unavailable=_unavailable(made) if made else {},
        limits_of=printing.number if printing else None,
        undecided=texts_of(decision, "reasons") if decision else (),
        certificates=tuple(map(certificate_shown, entries)),
        log=_log(manifest),
        settings=made.settings if made else {},
        results=tuple(
            ResultShown(**result.model_dump(include=set(ResultShown.model_fields)))
            for result in kept
        ),
        sources=_sources(run.id, home),
        standards=_standards(run.id, home),
    )


def certificate_shown(entry: Entry) -> CertificateShown:
    """A line of the register as pages show it."""
    return CertificateShown(**entry.model_dump(include=set(CertificateShown.model_fields)))


def _segments(manifest: Manifest, made: Calibration | None) -> Iterator[SegmentShown]:
    """Those of the manifest, or those that were found where it names none."""
    used = {segment.name: segment for segment in made.segments} if made else {}
    remarks = made.remarks if made else ()
    stated: Sequence[Segment | SegmentUsed] = manifest.segments or tuple(used.values())
    for segment in stated:
        as_used = used.get(segment.name)
        yield SegmentShown(
            name=segment.name, kind=segment.kind, t_start=segment.t_start, t_end=segment.t_end,
            up=segment.up, axis=segment.axis, rate_deg_s=segment.rate_deg_s,
            rows=as_used.rows if as_used else None,
            rows_left_out=as_used.rows_left_out if as_used else None,
            remarks=tuple(remark for remark in remarks if segment.name in remark.segments),
        )  # fmt: skip


def _elements(made: Calibration, limits: tuple[LimitDecision, ...]) -> Iterator[ElementShown]:
    for name, item in made.items.items():
        printed = column(list(item.value.values()), [item.U.get(e) for e in item.value], item.k)
        elements = list(item.value)
        for element in sorted(elements, key=partial(place, name)):
            i, value = elements.index(element), item.value[element]
            of_this = [each for each in limits if (each.item, each.element) == (name, element)]
            yield ElementShown(
                item=name, title=statement(item_title(name)), element=element,
                symbol=symbol(name, element), unit=item.unit, value=value,
                U=item.U.get(element), k=item.k, exponent=printed.exponent,
                value_text=printed.values[i], U_text=printed.uncertainties[i],
                limits=tuple(_limit(each, printed.exponent) for each in of_this),
                has_budget=element in item.budgets,
            )  # fmt: skip


def _limit(decision: LimitDecision, exponent: int) -> LimitShown:
    return LimitShown(
        decision=decision, text=limits_text(decision, exponent), margin=margin(decision)
    )


def margin(decision: LimitDecision) -> float | None:
    """How far a value is within the nearer limit, in U; negative outside of it."""
    if decision.value is None or not decision.U:
        return None
    lower = [] if decision.lower is None else [decision.value - decision.lower]
    upper = [] if decision.upper is None else [decision.upper - decision.value]
    return min([*lower, *upper]) / decision.U if lower or upper else None


def _unavailable(made: Calibration) -> dict[str, Statement]:
    reasons = {item: made.why_unavailable(item) for item in made.unavailable}
    return {item: why for item, why in reasons.items() if why}


def _log(manifest: Manifest) -> tuple[LogEntry, ...]:
    """What the run went through; nothing where no log of this program is in the manifest."""
    kept = (manifest.model_extra or {}).get("log") or ()
    try:
        return TypeAdapter(tuple[LogEntry, ...]).validate_python(kept)
    except ValidationError:
        return ()


def _sources(run: str, home: Home) -> tuple[str, ...]:
    source = tables.sources.c
    found = database.rows(home, sql.select(source.path).where(source.run == run))
    return tuple(row.path for row in found)


def _standards(run: str, home: Home) -> tuple[StandardUsed, ...]:
    used = tables.equipment.c
    columns = [used[name] for name in StandardUsed.model_fields]
    asked = sql.select(*columns).where(used.run == run).order_by(used.document, used.name)
    return tuple(StandardUsed(**row._mapping) for row in database.rows(home, asked))


def pdf_of(number: str, home: Home) -> tuple[str, bytes]:
    """The name and the bytes of a certificate's PDF; Unusable where it cannot be read."""
    path = home.path / certificates.entry_of(number, home).pdf
    try:
        return path.name, path.read_bytes()
    except OSError as error:
        raise Unusable(
            f"{path} cannot be read ({error.strerror}); restore it from a backup."
        ) from error
