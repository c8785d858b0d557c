"""Repeated samples: rows held, doubled or interpolated between their neighbours.

A sensor that scatters from row to row does not read the same twice on every axis, nor stand on the
straight line between its neighbours on every axis, but for rounding. How often chance does that
follows from the steps of the output and from how much the readings about a row change.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import poisson

from schemas.discrepancy import FoundParameter
from tasks.explain.channels import EVERY, TRIADS
from tasks.explain.events.event import TRIAD_NAMES, Event
from tasks.model.fit import plain_prediction
from tasks.motion.samples import interpolated
from tasks.motion.whole import Motion
from tasks.readings.lattice import Quantiser
from tasks.words import message

WINDOW = 16  # rows on either side that tell how much the readings change
UNLIKELY = 0.02  # chance of a repeat in a row below which it is counted
MIN_REPEATS = 10
EXCESS = 5.0  # times what chance makes
SIGNIFICANT = 1e-7
LAGS = (37, 41, 53)  # rows: farther than any logger holds one
HALF = 0.51  # step: how far rounding puts a row off the line between its neighbours
ROUNDING = 1e-7  # of the largest reading: less is the rounding of a file
FEW = 0.2  # of the rows: doubled ones, after which later stamps slip
BETTER = 0.7  # of the misfit: what the right one of two clocks leaves at most


@dataclass(frozen=True)
class RepeatedSamples(Event):
    """source: (n, 6) the row whose reading each one holds, or its own. slipped: (n,) s by which
    stamps are late where rows were doubled; zero where they were held.
    """

    source: np.ndarray
    slipped: np.ndarray

    @property
    def held(self) -> np.ndarray:
        """(n, 6) bool: the reading of another row."""
        return np.asarray(self.source != np.arange(len(self.source))[:, None])

    def sampled_at(self, t: np.ndarray) -> np.ndarray:
        return t - self.slipped

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        if self.slipped.any():
            return interpolated(self.sampled_at(t), t, predicted)
        return np.take_along_axis(predicted, self.source, axis=0)


def find_repeats(
    readings: np.ndarray, motion: Motion, quantisers: Sequence[Quantiser | None]
) -> RepeatedSamples | None:
    """Rows of readings (n, 6) that repeat others; quantisers: of each channel."""
    held, between = (np.zeros(readings.shape, bool) for _ in range(2))
    size = np.nan_to_num(np.nanmax(np.abs(np.diff(readings, axis=0)), axis=0, initial=0.0))
    steps = np.array([0.0 if q is None else q.step for q in quantisers])
    steps = np.maximum(steps, ROUNDING * np.nanmax(np.abs(readings), axis=0, initial=0.0))
    for channels in (EVERY, *TRIADS):  # whole rows, then those of a triad alone
        own = list(channels)
        if not (size[own] > 0.0).all():
            continue
        known = (held | between)[:, own].all(axis=1)
        held[:, own] |= (_held(readings[:, own], steps[own]) & ~known)[:, None]
        known = (held | np.roll(held, -1, axis=0) | between)[:, own].any(axis=1)
        rows = np.arange(float(len(readings)))  # a log that was brought to a higher rate afterwards
        for course in (motion.t, rows):
            straight = _between(course, readings[:, own], steps[own]) & ~known
            between[:, own] |= straight[:, None]
            if straight.any():
                break
    if not (held.any() or between.any()):
        return None
    return _event(held, between, _slipped(readings, motion, held))


def _held(readings: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """(n,) bool: rows of some channels (n, k) that hold the row before; none where chance may."""
    change = np.full(readings.shape, np.nan)
    change[1:] = np.abs(np.diff(readings, axis=0))
    apart = (np.abs(readings[lag:] - readings[:-lag]) for lag in LAGS)
    return _beyond_chance(change / steps, 0.5, (off / steps for off in apart))


def _between(t: np.ndarray, readings: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """(n,) bool: rows of some channels on the line between their neighbours, by the stamps."""
    off = np.full(readings.shape, np.nan)
    share = ((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]
    off[1:-1] = np.abs(readings[1:-1] - readings[:-2] - share * (readings[2:] - readings[:-2]))
    change = np.abs(np.diff(readings, axis=0)) < 0.5 * steps
    same = np.pad(change.all(axis=1), (1, 1))
    off[same[:-1] | same[1:]] = np.nan  # held rows are on a line, too
    middles = (
        readings[lag:-lag] - 0.5 * (readings[2 * lag :] + readings[: -2 * lag]) for lag in LAGS
    )
    return _beyond_chance(off / steps, HALF, (np.abs(middle) / steps for middle in middles))


def _beyond_chance(size: np.ndarray, within: float, distant: Iterable[np.ndarray]) -> np.ndarray:
    """(n,) bool: rows that are repeats in every channel, if they are more than chance makes.

    size: (n, k) steps by which each row is off a repeat; within: how many of them still are one.
    distant: the same for rows compared with others farther off, which no logger repeats. Chance
    as the readings about a row scatter; as they agree with distant ones; and as the rows are
    spread that are off by no more than a step, whatever their distribution, and be it one
    vibration that all channels share: it has no peak of its own at a repeat.
    """
    with np.errstate(invalid="ignore"):
        hit = np.asarray((size < within).all(axis=1))
        if np.count_nonzero(hit) < MIN_REPEATS:  # as in most recordings: chance need not be asked
            return np.zeros(len(hit), bool)
        near = np.asarray((size < within + 1.0).all(axis=1)) & ~hit
    reach = 2.0 * within / (np.sqrt(2.0 * np.pi) * _scale(hit, size))
    chance = np.prod(np.minimum(1.0, reach), axis=1)
    counted = chance < UNLIKELY
    seen = int((hit & counted).sum())
    usual = float(np.median([(each < within).all(axis=1).sum() for each in distant]))
    near_by = within * int((near & counted).sum())
    expected = EXCESS * max(float(chance[counted].sum()), near_by, usual)
    likely = seen < MIN_REPEATS or poisson.sf(seen - 1, expected) > SIGNIFICANT
    return np.zeros(len(hit), bool) if likely else hit


def _scale(hit: np.ndarray, size: np.ndarray) -> np.ndarray:
    """(n, k) root mean square of the size of rows that are no hit, on the quieter side of each."""
    used = ~hit & np.isfinite(size).all(axis=1)
    squares = np.vstack(
        [np.zeros(size.shape[1]), np.cumsum(np.where(used[:, None], size, 0.0) ** 2, axis=0)]
    )
    counts = np.concatenate([[0], np.cumsum(used)])
    rows = np.arange(len(hit))
    sides = []
    for first, last in ((rows - WINDOW, rows), (rows + 1, rows + 1 + WINDOW)):
        first, last = first.clip(0, len(hit)), last.clip(0, len(hit))
        number = counts[last] - counts[first]
        power = squares[last] - squares[first]
        mean = np.divide(
            power, number[:, None], out=np.zeros_like(power), where=number[:, None] > 0
        )
        sides.append(np.sqrt(np.maximum(mean, 0.0)))
    return np.maximum(np.minimum(*sides), 1e-300)


def _slipped(readings: np.ndarray, motion: Motion, held: np.ndarray) -> np.ndarray:
    """(n,) s by which stamps counted up from doubled rows are late; zero where the stamps fit."""
    nothing = np.zeros(len(held))
    doubled = held[:, :3].all(axis=1) & held[:, 3:].all(axis=1)
    if not doubled.any() or doubled.mean() > FEW:
        return nothing
    slipped = np.cumsum(doubled) * motion.interval
    late = motion.mapped(lambda values: _at(motion.t - slipped, motion.t, values))
    misfits = [
        np.nansum((readings - plain_prediction(readings, moved, held))[:, :3] ** 2)
        for moved in (motion, late)
    ]
    return slipped if misfits[1] < BETTER * misfits[0] else nothing


def _at(at: np.ndarray, t: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (n, …) at other times (n,) s."""
    flat = interpolated(at, t, values.reshape(len(values), -1))
    return flat.reshape(values.shape)


def _event(held: np.ndarray, between: np.ndarray, slipped: np.ndarray) -> RepeatedSamples:
    parameters, texts, channels = [], [], []
    own_row = np.arange(len(held))[:, None]
    source = np.maximum.accumulate(np.where(held, 0, own_row), axis=0)
    for triad, own in enumerate(TRIADS):
        for kind, rows in (("held", held[:, own[0]]), ("interpolated", between[:, own[0]])):
            if not rows.any():
                continue
            share, name = float(rows.mean()), ("gyro", "accel")[triad]
            doubled = kind == "held" and bool(slipped.any())
            way = "doubled" if doubled else kind
            u = float(np.sqrt(rows.sum())) / len(rows)
            parameters.append(FoundParameter(name=f"{way}_{name}", value=share, unit="1", u=u))
            texts.append(
                message(
                    f"events-repeats-{way}", sensors=TRIAD_NAMES[triad],
                    share=f"{100.0 * share:.2g}", count=int(rows.sum()),
                )
            )  # fmt: skip
            channels += [c for c in own if c not in channels]
    return RepeatedSamples(
        "repeated_samples", tuple(channels), tuple(parameters), SIGNIFICANT,
        message("events-repeats", kinds=tuple(texts)), source, slipped,
    )  # fmt: skip
