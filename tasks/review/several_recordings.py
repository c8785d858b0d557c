"""Effects that several recordings of one unit show together.

What the unit has is the same in all of them; what its station has is the same in those of that
station; a mounting has its own in each.
"""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigh
from scipy.special import chdtrc

from schemas.discrepancy import (
    Detection,
    Discrepancy,
    EvidenceFor,
    FoundParameter,
    HeldOut,
    Level,
    ReportedFinding,
    Verdict,
    Where,
)
from schemas.recording import Manifest, Station
from tasks.explain.explanation import CERTAIN, CHANNELS
from tasks.explain.report.statements import parameter_text, sentence, sentences
from tasks.explain.search.stepwise import PER_PARAMETER
from tasks.model.term import effect_name, separating_recording
from tasks.review.hypotheses import Effect, at_unit_information, ridged, solved
from tasks.review.pool import Pool, ReviewedRun
from tasks.review.random_effects import spreads
from tasks.review.search import FALSE_ALARMS, MOST_FINDINGS
from tasks.words import Sayable, clauses, message, statement
from tasks.words.numbers import plain, probability

OF_STATION = (
    "axis_tilt", "axis_nonorthogonality", "axis_wobble", "structural_compliance", "time_offset",
)  # fmt: skip
STATION_FAMILIES = ("table", "site")
OF_MOUNTING = ("lever_arm", "remount_misalignment")
FORETELLS = 4.0  # of the others' information: a run with more knows its values twice as well
LEAST_FORETOLD = 1.0  # nats that others must foretell of the runs, to be a test


@dataclass(frozen=True)
class FoundTogether:
    """An effect of several recordings.

    values: (groups, m) SI and covariance: (groups, m, m) of each group of recordings with values of
    their own; group: (runs,) of each. score: chi-squared gained less its price. p_value: corrected
    for how many were tried. held_out: nats gained in each run by the values of the others; None
    where the others say next to nothing of it. homogeneity_p: that the runs of a group have the
    same values; None where each has its own.
    names: other effects as likely.
    """

    effect: Effect
    values: np.ndarray
    covariance: np.ndarray
    group: np.ndarray
    score: float
    p_value: float
    held_out: float | None
    homogeneity_p: float | None
    names: tuple[str, ...] = ()


def found_together(pool: Pool) -> tuple[tuple[FoundTogether, ...], float]:
    """The effects, the strongest first, and the p value of the strongest mismatch."""
    found, strongest = list[FoundTogether](), 1.0
    while len(found) < MOST_FINDINGS:
        every = [one for effect in pool.effects if (one := _scored(pool, effect)) is not None]
        if not found:
            strongest = min((one.p_value for one in every), default=1.0)
        believed = [one for one in every if one.p_value < FALSE_ALARMS and _is_name(one)]
        if not believed:
            break
        best = max(believed, key=lambda one: one.score)
        names = {
            one.effect.name: None
            for one in sorted(believed, key=lambda one: -one.score)
            if one.score > best.score - CERTAIN and one.effect.name != best.effect.name
        }
        found.append(_with_names(best, tuple(names)))
        for number, values in enumerate(best.values):
            pool = pool.less(best.effect, values, best.group == number)
    return tuple(found), strongest


def groups_of(pool: Pool, effect: Effect) -> np.ndarray:
    """(runs,) the number of the group of runs that have the values of an effect in common."""
    term = effect.term
    if term.name in OF_MOUNTING:
        return np.arange(len(pool.runs))
    if term.name in OF_STATION or term.family in STATION_FAMILIES:
        return pool.carrier["station"]
    return np.zeros(len(pool.runs), int)


def _scored(pool: Pool, effect: Effect) -> FoundTogether | None:
    score, information = pool.evidence(effect)
    evidence = at_unit_information(score, information, np.zeros(len(score), int))
    if not evidence.size:
        return None
    group = groups_of(pool, effect)
    rows = np.array([group == number for number in range(int(group.max()) + 1)])
    (spread,) = spreads(evidence, (0.0,), (0.0,))
    gains = 2.0 * spread.gains(rows)
    gain, count = float(gains.sum()), evidence.size * len(rows)
    price = PER_PARAMETER * (count + len(effect.term.at))
    price += 2.0 * np.log(effect.trials) + effect.term.rarity
    price -= CERTAIN if effect.term.known and gain > 2.0 * CERTAIN else 0.0
    chances = float(chdtrc(count, gain))
    total, own = rows @ evidence.score, np.tensordot(rows * 1.0, evidence.information, axes=1)
    values = solved(own, total)
    back = evidence.back
    alone = solved(evidence.information, evidence.score)
    scatter = float((alone * evidence.score).sum() - (values * total).sum())
    free = evidence.size * (len(score) - len(rows))
    return FoundTogether(
        effect, values @ back.T, back @ np.linalg.pinv(own, hermitian=True) @ back.T, group,
        gain - price, min(1.0, chances * len(pool.effects)),
        _held_out(evidence.score, evidence.information, group),
        float(chdtrc(free, max(scatter, 0.0))) if free else None,
    )  # fmt: skip


def _held_out(score: np.ndarray, information: np.ndarray, group: np.ndarray) -> float | None:
    """Nats that the values of the other runs of its group gain in each run; None: no test."""
    gained, expected = 0.0, 0.0
    for run in range(len(score)):
        others = (group == group[run]) & (np.arange(len(score)) != run)
        theirs = information[others].sum(axis=0), score[others].sum(axis=0)
        values = _foretold(*theirs, information[run])
        foretold = 0.5 * float(values @ information[run] @ values)
        gained += float(score[run] @ values) - foretold
        expected += foretold
    return gained if expected >= LEAST_FORETOLD else None


def _foretold(information: np.ndarray, score: np.ndarray, own: np.ndarray) -> np.ndarray:
    """(m,) the values by some runs, in the directions that they determine well enough to say
    something of a run of own information (m, m); zero in the others.
    """
    ratios, directions = eigh(own, ridged(information))
    kept = directions[:, ratios < FORETELLS]
    return np.asarray(kept @ (score @ kept))


def _is_name(one: FoundTogether) -> bool:
    """Whether the values are plausible, and gain in runs that they were not taken from."""
    return _plausible(one) and (one.held_out is None or one.held_out > 0.0)


def _plausible(one: FoundTogether) -> bool:
    u = np.sqrt(np.maximum(np.diagonal(one.covariance, axis1=1, axis2=2), 0.0))
    low = np.array([p.low for p in one.effect.parameters]) - 2.0 * u
    high = np.array([p.high for p in one.effect.parameters]) + 2.0 * u
    return bool(((one.values >= low) & (one.values <= high)).all())


def _with_names(one: FoundTogether, names: tuple[str, ...]) -> FoundTogether:
    return FoundTogether(**{**vars(one), "names": names})


def reviewed_runs(manifests: Mapping[str, Manifest]) -> dict[str, ReviewedRun]:
    """Runs by their manifests, each with its carriers. A unit is identified by its serial
    number, and by its model too if several models share that number.
    """
    models: dict[str, set[str]] = {}
    for manifest in manifests.values():
        models.setdefault(manifest.unit.serial, set()).add(manifest.unit.model)
    shared = {serial for serial, of in models.items() if len(of) > 1}
    return {run: _reviewed(run, manifest, shared) for run, manifest in manifests.items()}


def _reviewed(run: str, manifest: Manifest, shared: set[str]) -> ReviewedRun:
    unit, free = manifest.unit, manifest.model_extra or {}
    serial = f"{unit.model} {unit.serial}" if unit.serial in shared else unit.serial
    carriers: dict[Level, str] = {
        "unit": serial, "station": manifest.station.id, "model": unit.model
    }  # fmt: skip
    named: dict[Level, Any] = {
        "lot": (unit.model_extra or {}).get("lot"),
        "site": _site(manifest.station),
    }
    carriers |= {level: str(name) for level, name in named.items() if name is not None}
    return ReviewedRun(run, str(free.get("acquired_at") or manifest.recording_id), carriers)


def _site(station: Station) -> Any:
    """The site that a station names, else its latitude and gravity, which stations there share."""
    named = (station.model_extra or {}).get("site")
    if named is not None or station.latitude_deg is None:
        return named
    gravity = "" if station.gravity_m_s2 is None else f", {station.gravity_m_s2:.4f} m/s²"
    return f"{station.latitude_deg:.2f}°{gravity}"


# The result for several recordings of one unit (`mimu-discrepancy/1`).

MOST_PARAMETERS = 3  # in a sentence
ANSWERS: Mapping[Verdict, str] = {
    "no_mismatch": "together-nothing", "unexplained": "together-unnamed",
    "partly_explained": "together-found", "explained": "together-found",
}  # fmt: skip


def discrepancy_together(
    unit: str,
    found: Sequence[FoundTogether],
    p_value: float,
    alone: Sequence[Discrepancy],
    fitted: Sequence[Discrepancy],
) -> Discrepancy:
    """The answer about recordings of a unit, one entry of `alone` and `fitted` for each.

    alone: what explain says of it by itself; fitted: with the effects found, and no others.
    """
    names = tuple(one.recording_id for one in alone)
    findings = tuple(_finding(one, names, fitted) for one in found)
    verdict = _verdict(found, p_value)
    every = clauses([effect_name(one.effect.name) for one in found])
    more = {"effects": every} if found else {"p": probability(p_value)}
    words = message(ANSWERS[verdict], count=len(names), unit=unit, **more)
    own = [
        message("together-alone", recording=one.recording_id, verdict=one.statement)
        for one in alone
    ]
    return Discrepancy(
        recording_id=" + ".join(names),
        digest=hashlib.sha256("\n".join(one.digest for one in alone).encode()).hexdigest(),
        code_version=alone[0].code_version,
        model=alone[0].model,
        verdict=verdict,
        detection=Detection(p_value=p_value, false_alarm_rate=FALSE_ALARMS),
        explained_share=_mean([one.explained_share for one in fitted]) if found else 0.0,
        left_over=_means([one.left_over for one in fitted]),
        findings=findings,
        held_out=_held_out_of_all([one.held_out for one in fitted]),
        remarks=tuple(statement(each) for each in own),
        statement=statement(sentence(words)),
    )


def _verdict(found: Sequence[FoundTogether], p_value: float) -> Verdict:
    if not found:
        return "no_mismatch" if p_value >= FALSE_ALARMS else "unexplained"
    return "partly_explained" if any(one.names for one in found) else "explained"


def held_out_gain(one: FoundTogether, fitted: Sequence[Discrepancy]) -> float:
    """Nats that an effect gains where its values were not taken from: other recordings, or, where
    those say next to nothing of it, the parts of each recording that its own fit did not see.
    """
    if one.held_out is not None:
        return one.held_out
    return sum(each.evidence.held_out_gain_nats for each in _of_effect(one, fitted))


def _of_effect(one: FoundTogether, fitted: Sequence[Discrepancy]) -> list[ReportedFinding]:
    return [each for of in fitted for each in of.findings if each.effect == one.effect.name]


def _finding(
    one: FoundTogether, names: Sequence[str], fitted: Sequence[Discrepancy]
) -> ReportedFinding:
    name = one.effect.name
    of_run = [[f for f in each.findings if f.effect == name][:1] for each in fitted]
    (like,) = next((some for some in of_run if some), (None,))
    parameters = tuple(_parameters(one, names))
    separating = separating_recording(name) if one.names else None
    sizes = tuple(parameter_text(each) for each in parameters[:MOST_PARAMETERS])
    parts: list[Sayable] = [
        message("together-evidence", effect=effect_name(name), gain=plain(one.score)),
        message("review-sizes", sizes=sizes),
    ]
    if one.names:
        others = tuple(effect_name(other) for other in one.names)
        parts.append(message("review-other-names", names=others))
    parts += [message("review-separated-by", recording=separating)] if separating else []
    channels = sorted({c for p in one.effect.parameters for c in p.channels})
    return ReportedFinding(
        effect=name,
        family=one.effect.term.family,
        title=statement(effect_name(name)),
        channels=tuple(CHANNELS[c] for c in channels),
        where=tuple(_where(of_run, names)),
        parameters=parameters,
        evidence=EvidenceFor(
            delta_bic=float(one.score), held_out_gain_nats=held_out_gain(one, fitted)
        ),
        share=_mean([some[0].share if some else 0.0 for some in of_run]),
        homogeneity_p=one.homogeneity_p,
        group=None,
        equation=like.equation if like else "",
        source=like.source if like else "",
        indistinguishable_from=one.names,
        separating_recording=statement(separating) if separating else None,
        next=like.next if like else statement(""),
        statement=statement(sentences([sentence(part) for part in parts])),
    )


def _parameters(one: FoundTogether, names: Sequence[str]) -> Iterator[FoundParameter]:
    """In the units that people read; named with their first recording where each group has its
    own.
    """
    for number, values in enumerate(one.values):
        u = np.sqrt(np.maximum(np.diag(one.covariance[number]), 0.0))
        first = names[int(np.argmax(one.group == number))]
        of_group = f" ({first})" if len(one.values) > 1 else ""
        for p, value, each in zip(one.effect.parameters, values, u, strict=True):
            yield FoundParameter(
                name=p.name + of_group, value=float(value) * p.factor, unit=p.unit,
                u=float(each) * p.factor,
            )  # fmt: skip


def _where(of_run: Sequence[Sequence[ReportedFinding]], names: Sequence[str]) -> Iterator[Where]:
    """Of each recording where it sits, its segments named with it; the shares add up to 1."""
    count = sum(bool(some) for some in of_run)
    for name, some in zip(names, of_run, strict=True):
        for place in (place for each in some for place in each.where):
            segments = tuple(f"{name}/{segment}" for segment in place.segments)
            yield place.model_copy(update={"segments": segments, "share": place.share / count})


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values))


def _means(some: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """The mean of each entry over those that have it."""
    keys = dict.fromkeys(key for each in some for key in each)
    return {key: _mean([each[key] for each in some if key in each]) for key in keys}


def _held_out_of_all(some: Sequence[HeldOut]) -> HeldOut:
    return HeldOut(
        rms_ratio=_means([one.rms_ratio for one in some]),
        chi2_per_dof_before=_mean([one.chi2_per_dof_before for one in some]),
        chi2_per_dof_after=_mean([one.chi2_per_dof_after for one in some]),
    )
