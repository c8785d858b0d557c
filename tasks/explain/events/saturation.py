"""Saturation: an output stops at a limit, noise included, perhaps rounded to steps afterwards.

A limit is a code of the output, alike for a triad, or a plateau of one axis and side.

What lies beyond the limit L piles up at it. With Gaussian noise σ about m the mean reading is
m − σ·h((L − m)/σ), with h(z) = φ(z) − z·(1 − Φ(z)) the mean of what is clipped.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr
from scipy.stats import binom

from schemas.discrepancy import FoundParameter
from tasks.explain.events.event import (
    CHANNELS,
    TRIAD_NAMES,
    UNITS,
    Event,
    Plateau,
    find_plateaus,
    noise_by_rate,
)
from tasks.explain.explanation import TRIADS
from tasks.model.fit import plain_prediction
from tasks.motion.whole import Motion
from tasks.readings.lattice import Quantiser
from tasks.words import message

EFFECTS = ("gyro_saturation", "accel_saturation")
SIDES = ((-1.0, 1.0), (1.0,), (-1.0,))  # a limit is looked for on both sides, then on one
SIGNIFICANT = 1e-6  # p-value below which readings pile up
MIN_BEYOND = 8.0  # readings that must be missing beyond a limit
NEGLIGIBLE = 3e-3  # of the noise: a mean that is shifted less is not disturbed
PLATEAU_P = 1e-9  # of readings that stay where they are while the prediction goes on, at most
MAX_CODES = 20  # below the limit, that the pile is compared with


@dataclass(frozen=True)
class Saturation(Event):
    """limits: size of each, by channel and side (1.0 above, −1.0 below). noise: (6,) near them."""

    linear = False

    limits: Mapping[tuple[int, float], float]
    noise: np.ndarray

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        clipped = predicted.copy()
        for (channel, side), limit in self.limits.items():
            loss = clipping_loss(side * predicted[:, channel], limit, self.noise[channel])
            clipped[:, channel] -= side * loss
        return clipped


@dataclass(frozen=True)
class ExtremeCode:
    """The outermost code of a triad's readings: how many hold it, and how unlikely that is."""

    limit: float
    step: float
    count: int
    p_value: float
    sides: tuple[float, ...]


def clipping_loss(mean: np.ndarray, limit: float, noise: float) -> np.ndarray:
    """How much of the mean (n,) is lost beyond a limit, σ·h((L − m)/σ)."""
    if noise <= 0:
        return np.maximum(mean - limit, 0.0)
    z = (limit - mean) / noise
    density = np.exp(-0.5 * np.minimum(z * z, 1400.0)) / np.sqrt(2 * np.pi)
    return noise * (density - z * ndtr(-z))


def find_saturation(
    readings: np.ndarray, motion: Motion, quantisers: Sequence[Quantiser | None]
) -> tuple[tuple[Saturation, ...], np.ndarray]:
    """Limits that readings stop at, and which readings (n, 6) bool they disturb."""
    masked = np.zeros(readings.shape, bool)
    events = []
    for triad, channels in enumerate(TRIADS):
        own = readings[:, channels]
        if not np.isfinite(own).any():
            continue
        step = min((q.step for c in channels if (q := quantisers[c]) is not None), default=0.0)
        scatter = float(np.nanmedian(np.abs(np.diff(own, axis=0))))
        for sides in SIDES:
            code = _extreme_code(own, sides, step, scatter)
            if code is None or code.p_value >= SIGNIFICANT:
                continue
            event, disturbed = _saturation(readings, motion, triad, code)
            if event is not None:
                events.append(event)
                masked |= disturbed
                break
    known = {place for event in events for place in event.limits}
    for event, disturbed in _at_plateaus(readings, motion, masked, known):
        events.append(event)
        masked |= disturbed
    return tuple(events), masked


def _at_plateaus(
    readings: np.ndarray, motion: Motion, masked: np.ndarray, known: Collection[tuple[int, float]]
) -> Iterator[tuple[Saturation, np.ndarray]]:
    """The event of each triad with plateaus at limits that are not known, and what it disturbs."""
    plateaus, disturbed, predicted = find_plateaus(readings, motion, masked)
    noise = _noise_near_limit(readings - predicted, motion, disturbed)
    new = [one for one in plateaus if (one.channel, one.side) not in known]
    for triad, channels in enumerate(TRIADS):
        own = [one for one in new if one.channel in channels]
        if own:
            yield _plateau_event(own, triad, noise), disturbed


def _plateau_event(plateaus: Sequence[Plateau], triad: int, noise: np.ndarray) -> Saturation:
    texts, parameters = [], []
    for one in plateaus:
        name = CHANNELS[one.channel]
        side, sign = ("upper", "+") if one.side > 0 else ("lower", "−")
        parameters.append(
            FoundParameter(
                name=f"{side}_limit_{name[-1]}", value=one.side * one.limit, unit=UNITS[triad],
                u=max(one.scatter, 1e-9 * one.limit),
            )
        )  # fmt: skip
        texts.append(
            message(
                "events-plateau-at", channel=message(f"channel-{name}"),
                limit=f"{sign}{one.limit:.5g} {UNITS[triad]}", count=one.count,
            )
        )  # fmt: skip
    channels = tuple(sorted({one.channel for one in plateaus}))
    return Saturation(
        EFFECTS[triad], channels, tuple(parameters), PLATEAU_P,
        message("events-plateau", sensors=TRIAD_NAMES[triad], limits=tuple(texts)),
        {(one.channel, one.side): one.limit for one in plateaus}, noise,
    )  # fmt: skip


def _extreme_code(
    readings: np.ndarray, sides: tuple[float, ...], step: float, scatter: float
) -> ExtremeCode | None:
    """Where a triad's readings (n, 3) end, and whether more lie there than in the codes below.

    The density of noise falls outwards. So the outermost code holds, but for the one reading that
    makes it the outermost, at most its share of what the codes next below hold.
    step: of the output, 0 without one. scatter: of a reading beside the next.
    """
    size = np.abs(readings) if len(sides) == 2 else sides[0] * readings
    top = float(np.nanmax(size))
    if not 0 < top < np.inf:
        return None
    width = step or 1e-7 * top
    below = int(np.clip(round((scatter or 1e-6 * top) / width / 2), 2, MAX_CODES))
    near = size[size > top - (below + 0.5) * width]
    count = int((near > top - 0.5 * width).sum())
    p_value = float(binom.sf(count - 2, len(near) - 1, 1 / (below + 1))) if count > 1 else 1.0
    return ExtremeCode(top, step, count, p_value, sides)


def _saturation(
    readings: np.ndarray, motion: Motion, triad: int, code: ExtremeCode
) -> tuple[Saturation | None, np.ndarray]:
    """The event, if what the rest of the readings predicts passes the limit; disturbed readings."""
    channels = TRIADS[triad]
    masked = np.zeros(readings.shape, bool)
    scatter = 3.0 * np.nanmedian(np.abs(np.diff(readings, axis=0)), axis=0)
    for channel in channels:
        for side in code.sides:
            masked[:, channel] |= side * readings[:, channel] > code.limit - scatter[channel]
    for _ in range(2):
        predicted = plain_prediction(readings, motion, masked)
        noise = _noise_near_limit(readings - predicted, motion, masked)
        masked[:] = False
        for channel in channels:
            for side in code.sides:
                loss = clipping_loss(side * predicted[:, channel], code.limit, noise[channel])
                masked[:, channel] |= loss > NEGLIGIBLE * noise[channel]
    own = list(channels)
    if _expected_beyond(predicted[:, own], code, noise[own]) < max(MIN_BEYOND, 0.1 * code.count):
        return None, masked
    edge = code.limit - code.step / 2 - 1e-12
    counts = {side: (side * readings[:, channels] > edge).sum(axis=0) for side in code.sides}
    sides = tuple(side for side in code.sides if counts[side].sum() > 1)
    where = tuple(c for k, c in enumerate(channels) if any(counts[side][k] > 1 for side in sides))
    u = max(code.step / np.sqrt(12), 1e-9 * code.limit)
    limit = FoundParameter(name="limit", value=code.limit, unit=UNITS[triad], u=u)
    sign = "±" if len(sides) == 2 else ("+" if sides[0] > 0 else "−")
    description = message(
        "events-saturation", sensors=TRIAD_NAMES[triad], count=code.count,
        limit=f"{sign}{code.limit:.6g} {UNITS[triad]}",
    )  # fmt: skip
    return Saturation(
        EFFECTS[triad], where, (limit,), code.p_value, description,
        {(c, side): code.limit for c in channels for side in sides}, noise,
    ), masked  # fmt: skip


def _noise_near_limit(residual: np.ndarray, motion: Motion, masked: np.ndarray) -> np.ndarray:
    """Noise (6,) at the rates of the masked readings, from those that no limit disturbs."""
    noise = noise_by_rate(np.where(masked, np.nan, residual), motion)
    near = [
        np.median(column[rows]) if rows.any() else np.median(column)
        for column, rows in zip(noise.T, masked.T, strict=True)
    ]
    return np.nan_to_num(near)


def _expected_beyond(predicted: np.ndarray, code: ExtremeCode, noise: np.ndarray) -> float:
    """How many readings should lie a whole code beyond the limit."""
    if not (noise > 0).all():
        return 0.0
    edge = code.limit + code.step
    return float(np.nansum([ndtr((side * predicted - edge) / noise) for side in code.sides]))
