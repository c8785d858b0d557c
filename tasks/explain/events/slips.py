"""Dropped samples: lost on the way, with stamps counted up from what arrived.

After each loss the stamps lag behind by so many sample intervals, so that a reading stamped t was
taken at t + δ, and differs from what is predicted for t by δ·dy/dt.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from schemas.discrepancy import FoundParameter
from tasks.explain.events.event import Event
from tasks.explain.events.matched import keeps_swinging, matched
from tasks.explain.events.plain import noise_of, read_at
from tasks.explain.events.stairs import CELL, Cells, Delays, stairs_of
from tasks.model.plain_fit import plain_prediction
from tasks.model.term import Text
from tasks.motion.whole import Motion

SHARP = 0.1  # of a sample interval: a cell that tells the delay worse tells none
FLAT = 0.5  # of the noise: what changes less from sample to sample is the encoders' noise
MODEL = 0.08  # of a sample interval: what else may look like a delay in a cell
STRAIGHT = 0.1  # of a cell's information: less is left beside a bias


@dataclass(frozen=True)
class Slips(Event):
    """times: (k,) s, stamps from which on. lost: (k,) whole samples. interval: s."""

    times: np.ndarray
    lost: np.ndarray
    interval: float

    def applied(self, t: np.ndarray, predicted: np.ndarray, noise: np.ndarray) -> np.ndarray:
        taken_at = t + delay(t, self.times, self.lost) * self.interval
        return read_at(taken_at, t, predicted)


def delay(t: np.ndarray, times: np.ndarray, lost: np.ndarray) -> np.ndarray:
    """Samples lost (n,) before each time."""
    return np.concatenate([[0], np.cumsum(lost)])[np.searchsorted(times, t, side="right")]


def find_slips(
    t: np.ndarray, readings: np.ndarray, motion: Motion, masked: np.ndarray
) -> Slips | None:
    """Losses that the stamps do not tell; masked: (n, 6) readings that a limit disturbs."""
    if len(t) < 3 or not motion.known.any():
        return None
    interval = float(np.median(np.diff(t)))
    predicted = plain_prediction(readings, motion, masked)
    noise = noise_of(readings - predicted, motion)
    slope = np.gradient(predicted, t, axis=0) * interval  # per sample interval
    slope = np.where(np.abs(slope) > FLAT * noise, slope, 0.0)
    found: Slips | None = None
    swinging = keeps_swinging(motion)
    cells: Cells
    for _ in range(2):  # the second time with a fit that the losses do not disturb
        read = np.where(masked, np.nan, readings)
        if swinging:
            cells = matched(t, read[:, :3], predicted[:, :3])
        else:
            cells = _delays(t, read - predicted, predicted, slope, noise)
        path = stairs_of(cells)
        if path is None:
            return None
        if swinging:
            noise = noise_of(read - _late(t, predicted, cells, path), motion)
        times, lost, u = _located(t, read, predicted, slope, noise, cells, path)
        found = _event(cells, path, times, lost, u, interval)
        shift = found.applied(t, predicted, noise) - predicted
        predicted = plain_prediction(readings - np.nan_to_num(shift), motion, masked)
    return found


def _delays(
    t: np.ndarray,
    residual: np.ndarray,
    predicted: np.ndarray,
    slope: np.ndarray,
    noise: np.ndarray,
) -> Delays:
    """The delay of each cell, from the gyros where they tell: levers disturb accelerometers.

    Beside it a cell may have a scale factor and a bias of its own: those of the whole run are
    fitted to readings that the losses have put off.
    """
    channels = range(3) if np.isfinite(residual[:, :3]).any() else range(3, 6)
    cell = ((t - t[0]) / CELL).astype(int)
    count = int(cell[-1]) + 1
    told, information = np.zeros(count), np.zeros(count)
    for c in channels:
        known = np.isfinite(residual[:, c] + slope[:, c] + noise[:, c])
        rows, number, weight = np.flatnonzero(known), cell[known], noise[known, c] ** -2
        forms = (slope[rows, c], residual[rows, c], predicted[rows, c], np.ones(len(rows)))
        gram = np.array(
            [[np.bincount(number, weight * x * y, count) for x in forms] for y in forms]
        )
        scaled = _without(gram, 2)
        both = _without(scaled, 3)
        # Where a ramp is straight a delay looks like a bias.
        gram = np.where(both[0, 0] > STRAIGHT * scaled[0, 0], both, scaled)
        told += gram[0, 1]
        information += np.maximum(gram[0, 0], 0.0)
    sharp = information > SHARP**-2
    u = np.sqrt(1 / information[sharp] + MODEL**2)
    middle = t[0] + (np.arange(count)[sharp] + 0.5) * CELL
    return Delays(middle, told[sharp] / information[sharp], u)


def _without(gram: np.ndarray, q: int) -> np.ndarray:
    """Products of some forms (k, k, cells) when one of them has been taken off the others."""
    shares = np.divide(gram[:, q], gram[q, q], out=np.zeros_like(gram[q]), where=gram[q, q] > 0)
    return np.asarray(gram - shares[:, None] * gram[q][None])


def _late(t: np.ndarray, predicted: np.ndarray, cells: Cells, path: np.ndarray) -> np.ndarray:
    """What is predicted (n, 6) for when the readings were taken, by the stairs and their foot."""
    step = np.clip(np.searchsorted(cells.at, t), 0, len(path) - 1)
    taken_at = t + (np.median(cells.delay - path) + path[step]) * float(np.median(np.diff(t)))
    return read_at(taken_at, t, predicted)


def _located(
    t: np.ndarray,
    readings: np.ndarray,
    predicted: np.ndarray,
    slope: np.ndarray,
    noise: np.ndarray,
    cells: Cells,
    path: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, samples lost and u of the times of each jump, from all rows about it."""
    start, interval = float(np.median(cells.delay - path)), float(np.median(np.diff(t)))
    times, lost, u = [], [], []
    for k in np.flatnonzero(np.diff(path)):
        first = int(np.searchsorted(t, cells.at[k] - cells.width / 2))
        last = int(np.searchsorted(t, cells.at[k + 1] + cells.width / 2))
        rows = slice(first, last)
        variance = noise[rows] ** 2 + (2 * MODEL * slope[rows]) ** 2
        before, after = (
            np.nan_to_num((readings[rows] - then) ** 2 / variance)
            for then in (
                read_at(t[rows] + (start + level) * interval, t, predicted)
                for level in (path[k], path[k + 1])
            )
        )
        # Chi-squared if the jump comes before row j: what is before it, and after it.
        cost = np.concatenate([[0.0], np.cumsum((before - after).sum(axis=1))])
        likely = first + np.flatnonzero(cost <= cost.min() + 4)
        low, high = t[likely[0]], t[min(likely[-1], len(t) - 1)]
        times.append(0.5 * (low + high))
        u.append(max((high - low) / np.sqrt(12), float(np.median(np.diff(t)))))
        lost.append(path[k + 1] - path[k])
    return np.array(times), np.array(lost), np.array(u)


def _event(
    cells: Cells,
    path: np.ndarray,
    times: np.ndarray,
    lost: np.ndarray,
    u: np.ndarray,
    interval: float,
) -> Slips:
    parameters = []
    level = {step: cells.u[path == step] for step in np.unique(path)}
    for k, (when, count) in enumerate(zip(times, lost, strict=True)):
        width = max(float(np.median(each)) / len(each) ** 0.5 for each in level.values())
        parameters += [
            FoundParameter(name=f"lost_{k + 1}", value=float(count), unit="1", u=width),
            FoundParameter(name=f"time_{k + 1}", value=float(when), unit="s", u=float(u[k])),
        ]
    gain = (
        cells.cost(np.median(cells.delay)).sum()
        - cells.cost(np.median(cells.delay - path) + path).sum()
    )
    return Slips(
        "dropped_samples", (0, 1, 2, 3, 4, 5), tuple(parameters),
        float(chi2.sf(gain, 2 * len(times))), _said(times, lost), None, times, lost, interval,
    )  # fmt: skip


def _said(times: np.ndarray, lost: np.ndarray) -> Text:
    english = ", ".join(f"{n:.0f} at {t:.1f} s" for t, n in zip(times, lost, strict=True))
    chinese = "、".join(f"{t:.1f} s 处 {n:.0f} 个" for t, n in zip(times, lost, strict=True))
    return (
        f"samples are lost and later time stamps slip: {english}",
        f"样本丢失，其后的时间戳随之滑移：{chinese}",
    )


def gaps(t: np.ndarray) -> tuple[Text, ...]:
    """What the stamps themselves tell of missing rows."""
    apart = np.diff(t)
    interval = float(np.median(apart)) if len(apart) else 1.0
    wide = apart > 1.5 * interval
    if not wide.any():
        return ()
    missing = int(np.round(apart[wide] / interval - 1).sum())
    count = int(wide.sum())
    return (
        (
            f"the time stamps have {count} gaps, of {missing} sample intervals in all; the other "
            f"stamps are right, so that this is no mismatch",
            f"时间戳有 {count} 处间断，共缺 {missing} 个采样间隔；其余时间戳正确，故不属模型不符",
        ),
    )
