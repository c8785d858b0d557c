"""The result of a review: findings, their carriers and since when, in words and numbers."""

from collections.abc import Sequence
from datetime import datetime

import numpy as np

from schemas.discrepancy import Detection, FoundParameter, Verdict
from schemas.review import (
    Carrier,
    Level,
    Moment,
    PooledEvidence,
    PooledValue,
    Review,
    ReviewFinding,
    Skipped,
)
from schemas.text import Statement
from tasks.explain.report.names import parameter_text, sentence
from tasks.explain.report.statements import sentences
from tasks.model.effect import effect_name, separating_recording
from tasks.review.carriers import Carried, Change
from tasks.review.pool import Pool
from tasks.review.search import FALSE_ALARMS, Found
from tasks.review.site import sites_of
from tasks.review.windows import Window, rows_of
from tasks.words import Message, Sayable, clauses, message, statement
from tasks.words.quantities import plain, probability

MOST_PARAMETERS = 3  # in a sentence


def review_of(
    pool: Pool, found: Sequence[Found], p_value: float, skipped: Sequence[Skipped] = ()
) -> Review:
    """The whole answer; found, p_value: what a search of the pool gave."""
    findings = tuple(_finding(one) for one in found)
    words = _summary(findings) if findings else _nothing(pool, p_value)
    return Review(
        runs=len(pool.runs),
        skipped=tuple(skipped),
        verdict=_verdict(findings),
        detection=Detection(p_value=p_value, false_alarm_rate=FALSE_ALARMS),
        findings=findings,
        sites=sites_of(pool),
        statement=sentence(words),
    )


def _verdict(findings: Sequence[ReviewFinding]) -> Verdict:
    """Partly explained where a name or a carrier is open."""
    if not findings:
        return "no_mismatch"
    is_open = any(one.indistinguishable_from or one.alternatives for one in findings)
    return "partly_explained" if is_open else "explained"


def _nothing(pool: Pool, p_value: float) -> Message:
    counts = {level: len(pool.names[level]) for level in ("unit", "station")}
    return message(
        "review-nothing", runs=len(pool.runs), units=counts["unit"], stations=counts["station"],
        p=probability(p_value),
    )  # fmt: skip


def _summary(findings: Sequence[ReviewFinding]) -> Message:
    carried = [
        message("review-carried", effect=effect_name(one.effect),
                carrier=_carrier(one.level, one.carrier))
        for one in findings
    ]  # fmt: skip
    return message("review-summary", count=len(findings), findings=clauses(carried))


def _finding(found: Found) -> ReviewFinding:
    best, pool = found.best, found.pool
    window = best.window
    alternatives = tuple(_alternative(pool, best, other) for other in found.carriers)
    names = tuple(other.effect.name for other in found.others)
    since, until = _moment(pool, found.since), _moment(pool, found.until)
    evidence = _evidence(found)
    parameters = _parameters(found)
    return ReviewFinding(
        effect=best.effect.name, level=window.level, carrier=_name(pool, window),
        alternatives=alternatives, since=since, until=until, parameters=parameters,
        evidence=evidence, indistinguishable_from=names,
        statement=_words(found, alternatives, since, until, parameters, evidence),
    )  # fmt: skip


def _name(pool: Pool, window: Window) -> str:
    return pool.names[window.level][window.carrier]


def _alternative(pool: Pool, best: Carried, other: Carried) -> Carrier:
    return Carrier(
        level=other.window.level, carrier=_name(pool, other.window),
        delta_bic=max(0.0, best.score - other.score),
    )  # fmt: skip


def _moment(pool: Pool, change: Change | None) -> Moment | None:
    if change is None:
        return None
    runs = (change.run, change.earliest, change.latest, change.without)
    run, earliest, latest, without = (pool.runs[k] for k in runs)
    return Moment(
        run=run.run, at=run.at, earliest=earliest.at, latest=latest.at, without=without.at
    )


def _parameters(found: Found) -> tuple[PooledValue, ...]:
    """In the units that people read; spread: of units and runs together."""
    best = found.best
    u = np.sqrt(np.maximum(np.diag(found.covariance), 0.0))
    one_run = np.sqrt((best.evidence.back**2).sum(axis=1))
    spread = float(np.hypot(best.spread.sigma, best.spread.tau)) * one_run
    return tuple(
        PooledValue(
            name=p.name, value=float(value) * p.factor, unit=p.unit, u=float(each) * p.factor,
            spread=float(wide) * p.factor,
        )
        for p, value, each, wide in zip(
            best.effect.parameters, found.values, u, spread, strict=True
        )
    )  # fmt: skip


def _evidence(found: Found) -> PooledEvidence:
    best, pool = found.best, found.pool
    rows = rows_of(pool, best.window)
    score, information = pool.evidence(best.effect)
    value = found.values
    power = np.einsum("rij,i,j->r", information[rows], value, value)
    shown = 2.0 * score[rows] @ value - power > 0.0
    return PooledEvidence(
        delta_bic=best.score, per_run_z_median=float(np.median(np.sqrt(np.maximum(power, 0.0)))),
        runs_that_show_it=int(shown.sum()), runs=int(rows.sum()),
    )  # fmt: skip


def _words(
    found: Found,
    alternatives: Sequence[Carrier],
    since: Moment | None,
    until: Moment | None,
    parameters: Sequence[FoundParameter],
    evidence: PooledEvidence,
) -> Statement:
    best = found.best
    own = _carrier(best.window.level, _name(found.pool, best.window))
    effect = effect_name(best.effect.name)
    sizes = tuple(parameter_text(each) for each in parameters[:MOST_PARAMETERS])
    parts: list[Sayable] = [
        message("review-carried", effect=effect, carrier=own),
        message("review-evidence", runs=evidence.runs, z=plain(evidence.per_run_z_median, 2),
                shown=evidence.runs_that_show_it, gain=plain(best.gain)),
        message("review-sizes", sizes=sizes),
    ]  # fmt: skip
    parts += [_changed(".since", since)] if since else []
    parts += [_changed(".until", until)] if until else []
    parts += [_deciding_run(best.window.level, own, other) for other in alternatives]
    if found.others:
        names = tuple(effect_name(other.effect.name) for other in found.others)
        parts.append(message("review-other-names", names=names))
        separating = separating_recording(best.effect.name)
        parts += [message("review-separated-by", recording=separating)] if separating else []
    return statement(sentences([sentence(part) for part in parts]))


def _deciding_run(level: Level, own: Message, other: Carrier) -> Message:
    """The run that would separate one carrier from another."""
    as_well = _carrier(other.level, other.carrier)
    pair = {level: own, other.level: as_well}
    if set(pair) == {"unit", "station"}:
        return message("review-deciding-run.unit", unit=pair["unit"], station=pair["station"])
    return message("review-deciding-run.other", carrier=own, other=as_well)


def _changed(side: str, moment: Moment) -> Message:
    if moment.earliest == moment.latest:
        return message(f"review-changed{side}-certain", run=moment.run, at=_minute(moment.at))
    return message(
        f"review-changed{side}", run=moment.run, at=_minute(moment.at),
        earliest=_minute(moment.earliest), latest=_minute(moment.latest),
    )  # fmt: skip


def _minute(at: str) -> str:
    """A moment to the minute in readable form; a recording's name unchanged."""
    try:
        moment = datetime.fromisoformat(at)
    except ValueError:
        return at
    return f"{moment:%Y-%m-%d %H:%M} {moment.tzname() or ''}".rstrip()


def _carrier(level: str, name: str) -> Message:
    return message(f"review-carrier.{level}", name=name)
