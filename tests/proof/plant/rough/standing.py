"""How far an effect stands above everything else in a rough recording.

z² = Σ |S(f)|² / L(f): S, what the effect changes in the misfit, L, the spectrum of the misfit
without it: noise, the reference's errors and whatever else is hidden. From both the standard's
columns took their part. With nothing but noise left, z is the visibility of the plain plant.

S is of readings before noise and rounding: each code that comes out otherwise, as the smallest
change makes of many, is a difference as large as a step, and chance. Only what a logger does is
seen in the codes alone.

What an effect adds at random, as a table's vibration that folds into the band, is no part of its
truth and would look the same whatever rectifies it: it belongs to L. Without an effect that
shakes the samples means, therefore, the same recording with the effect's strength at zero.
"""

import numpy as np

from schemas.recording import ACCEL, GYRO
from tests.proof.plant.effects.base import Effect
from tests.proof.plant.rough.case import RoughCase
from tests.proof.plant.rough.effects import KNOWN
from tests.proof.plant.rough.play import Played, play
from tests.proof.plant.unit import draw_unit

BY_SIZE = ("range_setting", "axis_mapping")  # the standard's columns take them: their size tells
FEWEST = 6  # frequencies in a band whose power is averaged
BANDS = 60
CLOSE = 0.15  # relative, of z asked for
TRIES = 8
SMALLEST, LARGEST = 1e-3, 15.0  # strengths: from 17 on some are beyond what is plausible


def standing(played: Played, rest: Played, by_size: bool = False) -> float:
    """z of what `played` has beyond `rest`, the same recording without it."""
    count = min(len(played.reported), len(rest.reported))
    signal = _difference(played, rest, count).T
    left = _misfit(rest, _logged(rest), rest.misread)[:count].T
    total = 0.0
    for channel in range(6):
        columns = _columns(rest.reported[:count], channel)
        series = signal[channel] if by_size else _without(columns, signal[channel])
        total += _above(series, _without(columns, left[channel]))
    return float(np.sqrt(total))


def without(rough: RoughCase, called: str) -> RoughCase:
    """The case with all of one effect gone but the random motion of the samples it comes with."""
    if KNOWN[called].shake is not Effect.shake:
        return rough.with_strength(called, 0.0)
    return rough.without(called)


def at_standing(rough: RoughCase, called: str, z: float) -> tuple[RoughCase, float]:
    """The case with one effect's strength set so that it stands z above the rest, and z reached.

    What has no size, starts at a threshold or cannot grow so far gets as near as it can.
    """
    effect, rest = KNOWN[called], play(without(rough, called))
    if not effect.sized and vars(effect).get("at") is None:
        return rough, standing(play(rough), rest, called in BY_SIZE)
    strength, tried = 1.0, list[tuple[float, float]]()
    for _ in range(TRIES):
        reached = standing(play(rough.with_strength(called, strength)), rest)
        tried.append((strength, reached))
        if abs(reached / z - 1.0) < CLOSE:
            break
        below = max((s for s, r in tried if r < z), default=0.0)
        above = min((s for s, r in tried if r >= z), default=np.inf)
        wanted = strength * float(np.clip(z / max(reached, 1e-9), 0.05, 20.0))
        if not below < wanted < above:
            wanted = float(np.sqrt(max(below, SMALLEST) * min(above, LARGEST)))
        strength = float(np.clip(wanted, SMALLEST, LARGEST))
    best = min(tried, key=lambda pair: abs(np.log(max(pair[1], 1e-9) / z)))
    return rough.with_strength(called, best[0]), best[1]


def _difference(played: Played, rest: Played, count: int) -> np.ndarray:
    """(count, 6) what the misfit has beyond that of the rest."""
    analog = _misfit(played, played.truth)[:count] - _misfit(rest, rest.truth)[:count]
    if analog.any():
        return analog
    return _misfit(played, _logged(played))[:count] - _misfit(rest, _logged(rest))[:count]


def _logged(played: Played) -> np.ndarray:
    return played.recording.imu.stack(GYRO + ACCEL)


def _misfit(played: Played, readings: np.ndarray, misread: np.ndarray | None = None) -> np.ndarray:
    """Readings (n, 6) less the true standard's model on the reported motion.

    misread: (n, 6) what the reference's noise adds to it.
    """
    reported = played.reported[: len(readings)]
    if misread is not None:
        reported = reported + misread[: len(reported)]
    unit = draw_unit(played.rough.case.seed)
    modelled = unit.reads(reported[:, :3].T, reported[:, 3:].T).T
    return np.asarray(readings[: len(reported)] - modelled)


def _columns(reported: np.ndarray, channel: int) -> np.ndarray:
    """The standard's columns of a channel, those that vary, at one size; and the constant."""
    rates, force = reported[:, :3], reported[:, 3:]
    more = rates if channel < 3 else np.delete(rates, channel - 3, axis=1) ** 2
    columns = np.hstack([force, more])
    columns = columns - columns.mean(axis=0)
    size = np.sqrt((columns**2).mean(axis=0))
    kept = columns[:, size > 1e-6] / size[size > 1e-6]
    return np.column_stack([np.ones(len(reported)), kept])


def _without(columns: np.ndarray, series: np.ndarray) -> np.ndarray:
    found, *_ = np.linalg.lstsq(columns, series, rcond=1e-10)
    return np.asarray(series - columns @ found)


def _above(signal: np.ndarray, left: np.ndarray) -> float:
    """Σ over frequencies of signal power over the power of what is left, band by band."""
    observation, rest = (np.abs(np.fft.rfft(series)[1:]) ** 2 for series in (signal, left))
    edges = np.unique(np.geomspace(FEWEST, len(rest), BANDS).astype(int))
    edges = np.concatenate([[0], edges])
    power = np.add.reduceat(rest, edges[:-1]) / np.diff(edges)
    return float((2.0 * np.add.reduceat(observation, edges[:-1]) / power).sum())
