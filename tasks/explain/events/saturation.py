"""Saturation: an output stops at a limit, noise included; rounding to steps may follow.

What lies beyond the limit L piles up at it. With Gaussian noise σ about m the mean reading is
m − σ·h((L − m)/σ), with h(z) = φ(z) − z·(1 − Φ(z)) the mean of what is cut off.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr
from scipy.stats import binom

from schemas.discrepancy import FoundParameter
from tasks.explain.channels import TRIADS
from tasks.explain.events.event import TRIAD_NAMES, UNITS, Event
from tasks.explain.events.plain import noise_of
from tasks.explain.events.steps import codes_of
from tasks.model.plain_fit import plain_prediction
from tasks.model.term import Text
from tasks.motion.whole import Motion

NAMES = ("gyro_saturation", "accel_saturation")
SIDES = ((-1.0, 1.0), (1.0,), (-1.0,))  # a limit is looked for on both sides, then on one
SURE = 1e-6  # p-value below which readings pile up
BEYOND = 8.0  # readings that must be missing beyond a limit
NOTICED = 3e-3  # of the noise: a mean that is shifted less is not disturbed
FARTHEST = 20  # codes below the limit that the pile is compared with


@dataclass(frozen=True)
class Saturation(Event):
    """triad: 0 gyros, 1 accelerometers. sides: of the limit. noise: (3,) near the limit."""

    triad: int
    limit: float
    sides: tuple[float, ...]
    noise: np.ndarray

    def applied(self, t: np.ndarray, predicted: np.ndarray, noise: np.ndarray) -> np.ndarray:
        stopped = predicted.copy()
        for axis, channel in enumerate(TRIADS[self.triad]):
            for side in self.sides:
                lost = cut_off(side * predicted[:, channel], self.limit, self.noise[axis])
                stopped[:, channel] -= side * lost
        return stopped


@dataclass(frozen=True)
class Pile:
    """Readings that pile up at an extreme code, and how surely."""

    limit: float
    step: float
    count: int
    p_value: float
    sides: tuple[float, ...]


def cut_off(mean: np.ndarray, limit: float, noise: float) -> np.ndarray:
    """How much of the mean is lost beyond a limit, σ·h((L − m)/σ)."""
    if noise <= 0:
        return np.maximum(mean - limit, 0.0)
    z = (limit - mean) / noise
    density = np.exp(-0.5 * np.minimum(z * z, 1400.0)) / np.sqrt(2 * np.pi)
    return noise * (density - z * ndtr(-z))


def find_saturation(
    readings: np.ndarray, motion: Motion
) -> tuple[tuple[Saturation, ...], np.ndarray]:
    """Limits that readings stop at, and which readings (n, 6) bool they disturb."""
    masked = np.zeros(readings.shape, bool)
    found = []
    for triad in range(2):
        piles = (_pile(readings[:, TRIADS[triad]], sides) for sides in SIDES)
        sure = [pile for pile in piles if pile is not None and pile.p_value < SURE]
        for pile in sure:
            event, disturbed = _seen(readings, motion, triad, pile)
            if event is not None:
                found.append(event)
                masked |= disturbed
                break
    return tuple(found), masked


def _pile(readings: np.ndarray, sides: tuple[float, ...]) -> Pile | None:
    """Where the readings end, and whether more of them lie there than in the codes below.

    The density of noise falls outwards. So the outermost code holds, but for the one reading that
    makes it the outermost, at most its share of what the codes next below hold.
    """
    steps = [codes.step for codes in map(codes_of, readings.T) if codes is not None]
    size = np.abs(readings) if len(sides) == 2 else sides[0] * readings
    top = float(np.nanmax(size, initial=-np.inf))
    if not np.isfinite(top) or top <= 0:
        return None
    scatter = float(np.nanmedian(np.abs(np.diff(readings, axis=0)))) or 1e-6 * top
    step = min(steps) if steps else 1e-7 * top
    below = int(np.clip(round(scatter / step / 2), 2, FARTHEST))
    near = size[size > top - (below + 0.5) * step]
    count = int((near > top - 0.5 * step).sum())
    rest = len(near) - count
    p_value = float(binom.sf(count - 2, count - 1 + rest, 1 / (below + 1))) if count > 1 else 1.0
    return Pile(top, step if steps else 0.0, count, p_value, sides)


def _seen(
    readings: np.ndarray, motion: Motion, triad: int, pile: Pile
) -> tuple[Saturation | None, np.ndarray]:
    """The event, if what the rest of the readings predicts passes the limit."""
    channels = TRIADS[triad]
    masked = np.zeros(readings.shape, bool)
    scatter = 3.0 * np.nanmedian(np.abs(np.diff(readings, axis=0)), axis=0)
    for channel in channels:
        for side in pile.sides:
            masked[:, channel] |= side * readings[:, channel] > pile.limit - scatter[channel]
    for _ in range(2):
        predicted = plain_prediction(readings, motion, masked)
        noise = _noise_near(readings, predicted, motion, masked)[list(channels)]
        masked[:] = False
        for axis, channel in enumerate(channels):
            for side in pile.sides:
                lost = cut_off(side * predicted[:, channel], pile.limit, noise[axis])
                masked[:, channel] |= lost > NOTICED * noise[axis]
    beyond = _beyond(predicted[:, channels], pile, noise)
    if beyond < max(BEYOND, 0.1 * pile.count):
        return None, masked
    stopped = np.abs(readings[:, channels] * _side(pile)) > pile.limit - pile.step / 2 - 1e-12
    where = tuple(c for axis, c in enumerate(channels) if stopped[:, axis].sum() > 1)
    rows: np.ndarray = np.asarray(masked.any(axis=1))
    return (
        Saturation(
            NAMES[triad], where, _parameters(triad, pile), pile.p_value,
            _said(triad, pile), rows, triad, pile.limit, pile.sides, noise,
        ),
        masked,
    )  # fmt: skip


def _noise_near(
    readings: np.ndarray, predicted: np.ndarray, motion: Motion, masked: np.ndarray
) -> np.ndarray:
    """Noise (6,) at the highest rates, from readings that no limit disturbs."""
    free = np.where(masked, np.nan, readings - predicted)
    noise = noise_of(free, motion)
    near = np.array([np.median(noise[masked[:, c], c]) if masked[:, c].any()
                     else np.median(noise[:, c]) for c in range(6)])  # fmt: skip
    return np.nan_to_num(near)


def _beyond(predicted: np.ndarray, pile: Pile, noise: np.ndarray) -> float:
    """How many readings should lie a whole code beyond the limit."""
    if not (noise > 0).all():
        return 0.0
    edge = pile.limit + pile.step
    tails = [ndtr((side * predicted - edge) / noise) for side in pile.sides]
    return float(np.nansum(tails))


def _side(pile: Pile) -> float:
    return 1.0 if len(pile.sides) == 2 else pile.sides[0]


def _parameters(triad: int, pile: Pile) -> tuple[FoundParameter, ...]:
    u = max(pile.step / np.sqrt(12), 1e-9 * pile.limit)
    return (FoundParameter(name="limit", value=pile.limit, unit=UNITS[triad], u=u),)


def _said(triad: int, pile: Pile) -> Text:
    english, chinese = TRIAD_NAMES[triad]
    sign = "±" if len(pile.sides) == 2 else ("+" if pile.sides[0] > 0 else "−")
    limit = f"{sign}{pile.limit:.6g} {UNITS[triad]}"
    return (
        f"the {english} stop at {limit}: {pile.count} readings lie there and none beyond",
        f"{chinese}输出止于 {limit}：有 {pile.count} 个读数停在该处，无一超出",
    )
