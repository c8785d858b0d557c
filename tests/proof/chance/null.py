"""Null recordings: what an accepted model predicts, with its own residual torn out of its order.

A fast part and a slow one are treated apart, because a slow one that is turned round or moved in
stretches would jump at their ends as no sensor does. The slow part, a running median that keeps
steps, is cut where a channel crosses zero, each channel by itself.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import median_filter

from schemas.recording import ACCEL, GYRO, Recording
from tasks.explain.explanation import UNNAMED, Explanation, Finding
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.readings.lattice import quantiser_of

CHANNELS = (*GYRO, *ACCEL)
TRIADS = (slice(0, 3), slice(3, 6))
STRETCH = 5.0, 30.0  # s, shortest and longest: longer than what a unit remembers of a motion
Tear = Callable[[list[np.ndarray], np.random.Generator], list[np.ndarray]]


@dataclass(frozen=True, eq=False)
class Accepted:
    """What was accepted of a recording.

    recording: its readings as explain has them. found: (n, 6), what its model predicts, NaN where
    that is not known. named: the first names it gave; names: with all that they cannot be told
    from. unreported: others in its model, as of what lost its name or belongs to a tracked body.
    """

    recording: Recording
    found: np.ndarray
    named: frozenset[str]
    names: frozenset[str]
    unreported: frozenset[str]


def accepted(recording: Recording, explanation: Explanation) -> Accepted:
    """recording: what was explained; its reference stays as it was, in its own axes."""
    every = (*explanation.findings, *explanation.small)
    names = frozenset[str]().union(*map(offered, every))
    model = explanation.determined
    terms = {key[0] for key in model.model.places} if model else set()
    terms |= {one.refusal.name for one in every if one.refusal}
    unreported = terms - names - {UNNAMED, *(term.name for term in STANDARD_TERMS)}
    own = replace(explanation.recording, reference=recording.reference)
    named = frozenset(one.effect for one in every) - {UNNAMED}
    return Accepted(own, explanation.found, named, names, frozenset(unreported))


def offered(finding: Finding) -> set[str]:
    """Every name that a finding offers for what it found; none of one without a name."""
    if finding.effect == UNNAMED:
        return set()
    return {finding.effect, *finding.group, *finding.indistinguishable}


def null_recording(of: Accepted, tear: Tear, rng: np.random.Generator) -> Recording:
    """The accepted model's readings with its residual torn, rounded to the codes of the recording.

    Others stay as they were recorded. Rows on codes beside rows off them would be no log at all.
    """
    imu = of.recording.imu
    readings = imu.stack(CHANNELS)
    known = np.isfinite(of.found) & np.isfinite(readings)
    interval = float(np.median(np.diff(imu.t)))
    null = readings.copy()
    for triad in TRIADS:
        rows = known[:, triad].all(axis=1)
        residual = (readings - of.found)[rows, triad]
        null[rows, triad] = of.found[rows, triad] + torn(residual, interval, tear, rng)
    for c, quantiser in enumerate(map(quantiser_of, readings.T)):
        if quantiser is not None:
            null[:, c] = quantiser.offset + quantiser.step * quantiser.codes(null[:, c])
    own = {c: null[:, k] for k, c in enumerate(CHANNELS) if c in imu.columns}
    return replace(of.recording, imu=replace(imu, columns={**imu.columns, **own}), digest="")


def torn(residual: np.ndarray, interval: float, tear: Tear, rng: np.random.Generator) -> np.ndarray:
    """(n, 3) of a triad: stretches of the fast part with all channels together, and of the slow.

    interval: s from row to row. What tear does to stretches keeps their power.
    """
    shortest, longest = (max(1, round(seconds / interval)) for seconds in STRETCH)
    if not len(residual):
        return residual
    slow = np.column_stack(
        [median_filter(each, shortest | 1, mode="nearest") for each in residual.T]
    )
    cuts = np.cumsum(rng.integers(shortest, longest + 1, 1 + len(residual) // shortest))
    fast = np.concatenate(tear(np.split(residual - slow, cuts[cuts < len(residual)]), rng))
    sewn = [_sewn(column, tear, rng) for column in slow.T]
    return np.asarray(fast + np.column_stack(sewn))


def _sewn(slow: np.ndarray, tear: Tear, rng: np.random.Generator) -> np.ndarray:
    """(n,) torn between its zero crossings. What is before the first and after the last ends at
    none: it stays in its place, with either sign.
    """
    first, *between = np.split(slow, 1 + np.flatnonzero(np.diff(np.sign(slow))))
    last = between.pop() if between else slow[:0]
    signs = rng.choice([-1.0, 1.0], 2)
    return np.concatenate([signs[0] * first, *tear(between, rng), signs[1] * last])


def flipped(parts: list[np.ndarray], rng: np.random.Generator) -> list[np.ndarray]:
    """Half of them with the other sign, at random: as many, so that few leave nothing as it was."""
    turned = rng.permutation(np.arange(len(parts)) % 2)
    return [-one if turn else one for one, turn in zip(parts, turned, strict=True)]


def scrambled(parts: list[np.ndarray], rng: np.random.Generator) -> list[np.ndarray]:
    """All of them in another order."""
    return [parts[k] for k in rng.permutation(len(parts))]
