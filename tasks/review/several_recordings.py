"""Effects that several recordings of one unit show together.

What the unit has is the same in all of them; what its station has is the same in those of that
station; a mounting has its own in each.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigh
from scipy.special import chdtrc

from schemas.recording import Manifest, Station
from schemas.review import Level
from tasks.explain.odds import CERTAIN
from tasks.explain.search.scores import PER_PARAMETER
from tasks.review.evidence import at_unit_information, ridged, solved
from tasks.review.hypotheses import Effect
from tasks.review.pool import Pool, ReviewedRun
from tasks.review.random_effects import spreads
from tasks.review.search import FALSE_ALARMS, MOST_FINDINGS

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
            one.effect.name: None for one in sorted(believed, key=lambda one: -one.score)
            if one.score > best.score - CERTAIN and one.effect.name != best.effect.name
        }  # fmt: skip
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
