"""The result of a review: findings, their carriers and since when, in words and numbers."""

from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime

import numpy as np

from schemas.discrepancy import (
    Carrier,
    Consequence,
    Detection,
    EstimatedSite,
    FoundParameter,
    Level,
    Moment,
    PooledEvidence,
    PooledValue,
    Review,
    ReviewFinding,
    Skipped,
    Touched,
    Verdict,
)
from schemas.laboratory import EquipmentLimit, LimitName
from schemas.recording import ANGLE, Recording
from schemas.text import Statement
from tasks.explain.correction.adopt import corrected
from tasks.explain.correction.consequences import by_clauses, moved
from tasks.explain.explanation import CHANNELS
from tasks.explain.inputs.prepared import without_faults
from tasks.explain.report.statements import element_title, parameter_text, sentence, sentences
from tasks.explain.search.candidates import columns_of
from tasks.model.catalogue import catalogue
from tasks.model.fit import inverse
from tasks.model.term import effect_name, separating_recording
from tasks.motion.table import EARTH_RATE
from tasks.motion.whole import Motion
from tasks.readings.codes import codes_put_right, offset_taken_off
from tasks.review.carriers import Carried, Change
from tasks.review.hypotheses import NAME, Effect, identity
from tasks.review.pool import Pool, layout_of
from tasks.review.search import FALSE_ALARMS, Found
from tasks.review.windows import Window, rows_of
from tasks.words import Message, Sayable, clauses, message, statement
from tasks.words.numbers import multiple, plain, probability, quantity

K = 2.0
CLEAR = 3.0  # standard uncertainties of the level rate from which on it has a direction
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
        statement=statement(sentence(words)),
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
                carrier=_carrier(one.level, one.carrier), runs=one.evidence.runs)
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
    same = best.effect == other.effect  # each window beside a spread of its own
    less = best.total - other.total if same else best.score - other.score
    return Carrier(
        level=other.window.level, carrier=_name(pool, other.window), delta_bic=max(0.0, less)
    )


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
    name = _name(found.pool, best.window)
    own = _carrier(best.window.level, name)
    effect = effect_name(best.effect.name)
    sizes = tuple(parameter_text(each) for each in parameters[:MOST_PARAMETERS])
    parts: list[Sayable] = [
        message("review-carried", effect=effect, carrier=own, runs=evidence.runs),
        message("review-evidence", runs=evidence.runs, z=plain(evidence.per_run_z_median, 2),
                shown=evidence.runs_that_show_it, p=probability(best.p_value)),
        message("review-sizes", sizes=sizes),
    ]  # fmt: skip
    parts += [_changed(".since", since)] if since else []
    parts += [_changed(".until", until)] if until else []
    parts += [deciding_run(best.window.level, name, other) for other in alternatives]
    if found.others:
        names = tuple(effect_name(other.effect.name) for other in found.others)
        parts.append(message("review-other-names", names=names))
        separating = separating_recording(best.effect.name)
        parts += [message("review-separated-by", recording=separating)] if separating else []
    return statement(sentences([sentence(part) for part in parts]))


def deciding_run(level: Level, carrier: str, other: Carrier) -> Message:
    """The run that would separate one carrier from another."""
    own, as_well = _carrier(level, carrier), _carrier(other.level, other.carrier)
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


# Latitude and heading of a station that its manifests omit, from Earth's rotation.
#
# In the runs of a station the ground turns about one direction of its base, whatever unit is on it.
# The part along the vertical cannot be told from gyros that follow gravity, which the standard's
# model lets them do; the level part Ω·cos φ can, and points north.


def sites_of(pool: Pool) -> tuple[EstimatedSite, ...]:
    """What the runs of each station say of its site, where their manifests do not."""
    terms = {identity(t): t for g in pool.groups for t in g.layout.terms if t.name == NAME}
    return tuple(site for term in terms.values() for site in _sites(pool, Effect(term, (0, 1))))


def _sites(pool: Pool, level: Effect) -> Iterator[EstimatedSite]:
    score, information = pool.evidence(level)
    seen = information.any(axis=(1, 2))
    for number, station in enumerate(pool.names["station"]):
        rows = seen & (pool.carrier["station"] == number)
        if rows.any():
            covariance = inverse(information[rows].sum(axis=0))
            yield estimated(
                station, int(rows.sum()), covariance @ score[rows].sum(axis=0), covariance
            )


def estimated(station: str, runs: int, rate: np.ndarray, covariance: np.ndarray) -> EstimatedSite:
    """rate: (2,) rad/s of the ground along the table's x and y axes, all angles zero."""
    size = float(np.hypot(*rate))
    along, across = rate / size, np.array([rate[1], -rate[0]]) / size
    u_size = float(np.sqrt(along @ covariance @ along))
    u_turn = float(np.degrees(np.sqrt(across @ covariance @ across) / size))
    cosine = size / EARTH_RATE
    if size < CLEAR * u_size or cosine > 1.0 + CLEAR * u_size / EARTH_RATE:
        nothing = message("review-site-unknown", station=station, runs=runs)
        return EstimatedSite(
            station=station, runs=runs, latitude_deg=None, latitude_expanded=None,
            heading_deg=None, heading_expanded=None, statement=statement(nothing),
        )  # fmt: skip
    latitude = float(np.degrees(np.arccos(min(cosine, 1.0))))
    sine = max(np.sin(np.radians(latitude)), np.sqrt(K * u_size / EARTH_RATE))  # near the equator
    wide = K * float(np.degrees(u_size / EARTH_RATE / sine))
    heading = float(np.degrees(np.arctan2(-rate[0], rate[1])))
    words = message(
        "review-site", station=station, runs=runs, latitude=quantity(latitude, wide, "deg"),
        heading=quantity(heading, K * u_turn, "deg"),
    )  # fmt: skip
    return EstimatedSite(
        station=station, runs=runs, latitude_deg=latitude, latitude_expanded=wide,
        heading_deg=heading, heading_expanded=K * u_turn, statement=statement(words),
    )  # fmt: skip


# How an effect that runs have in common changes the elements of a certificate.


def moved_elements(
    recording: Recording, effect: Effect, values: np.ndarray,
    limits: Mapping[LimitName, EquipmentLimit] | None = None,
) -> list[Consequence]:  # fmt: skip
    """The elements of a recording's items that an effect of values (m,) SI moves by more than
    0.05 U, as read and less the effect; none where its clauses go by angles. limits: of the
    equipment, as of `calibrate`.

    Raises Unusable where the clauses give no items.
    """
    if all(name in recording.imu.columns for name in ANGLE):
        return []
    recording = offset_taken_off(recording)
    _, _, full = without_faults(recording, codes_put_right(recording))
    added = contribution(recording, full.motion, effect, values)
    before = by_clauses(recording, limits)
    after = by_clauses(corrected(recording, [added]), limits)
    return [each for each in moved(before, after) if each.in_U]


def contribution(
    recording: Recording, motion: Motion, effect: Effect, values: np.ndarray
) -> np.ndarray:
    """(n, 6) rad/s and m/s² that an effect of values (m,) SI adds to the readings."""
    added = np.zeros((len(motion.t), len(CHANNELS)))
    for term in catalogue(recording, motion):
        if term.name != effect.name or term.at != effect.term.at:
            continue
        columns = columns_of(term, motion)
        if identity(layout_of([term], [columns]).terms[0]) != identity(effect.term):
            continue
        for q, value in zip(effect.own, values, strict=True):
            for channel, column in columns[q].items():
                added[:, channel] += value * np.nan_to_num(column)
        return added
    return added


def touched_of(certificate: str, elements: Sequence[Consequence]) -> Iterator[Touched]:
    """The elements as elements of a certificate, in its U."""
    for each in elements:
        yield Touched(certificate=certificate, item=each.item, element=each.element, in_U=each.in_U)


def with_touched(finding: ReviewFinding, touched: Sequence[Touched], looked: int) -> ReviewFinding:
    """The finding with what it moves, the most first, and says so; looked: at so many
    certificates.
    """
    ordered = tuple(sorted(touched, key=lambda each: -abs(each.in_U)))
    if not looked:
        return finding
    words = message("review-touches-none", looked=looked)
    if ordered:
        most = ordered[0]
        words = message(
            "review-touches", count=len({each.certificate for each in ordered}), looked=looked,
            certificate=most.certificate, times=multiple(most.in_U),
            element=element_title(most.item, most.element),
        )  # fmt: skip
    statement_ = statement(sentences([finding.statement, sentence(words)]))
    return finding.model_copy(update={"touched": ordered, "statement": statement_})
