"""Bursts: damped swings that start at odd times, all of one frequency and one decay."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import correlate
from scipy.stats import gamma

from schemas.discrepancy import FoundParameter
from schemas.recording import ACCEL, GYRO
from tasks.explain.events.event import UNITS, named
from tasks.explain.events.regimes import CHANGES, levels, regimes_at, without_louder
from tasks.explain.events.ringing import OVER, Ringing, fitted_waves, shape_of, swings
from tasks.explain.events.swings import FILLED, Swing, standing_out
from tasks.model.term import Text
from tasks.motion.whole import Motion

RATE = 25.0  # Hz, of the blocks that bursts are looked for in
FALSE_ALARM = 1e-6  # its trials are not quite counted: waves, fadings and starts are correlated
SURE = 5.0  # of the noise: a further burst of a known wave
ALIKE = (0.5, 2.0)  # sizes of a further burst, over that of the known one
FEWEST = 100  # rows
MOST = 60  # bursts; more are no odd events
ROUNDS = 3
SEEN = 4.0  # standard uncertainties from which a channel has the bursts
LONGEST = 8.0  # s that a burst may fade in


@dataclass(frozen=True)
class Blocks:
    """t: (m,) s. left: (m, 6) means; weight: (m, 6) one over their noise, 0 where not known."""

    t: np.ndarray
    left: np.ndarray
    weight: np.ndarray
    regime: np.ndarray


@dataclass(frozen=True)
class Kind:
    """Bursts of one kind: starts (m,) s, and one wave (6,) complex of them all."""

    starts: np.ndarray
    wave: np.ndarray
    gain: np.ndarray
    frequency: float
    decay: float


def find_bursts(
    t: np.ndarray, residual: np.ndarray, noise: np.ndarray, motion: Motion
) -> Ringing | None:
    """Bursts in what a fit leaves (n, 6), NaN: not known; noise: (n, 6), its level at each row."""
    if len(t) < FEWEST:
        return None
    blocks = _blocks(t, residual, noise, motion)
    channels = np.flatnonzero(blocks.weight.any(axis=0))
    if len(channels) == 0:
        return None
    white = (blocks.left * blocks.weight)[:, channels]
    strong, looked = standing_out(blocks.t, white, motion, FALSE_ALARM)
    if not strong or len(strong) > MOST:
        return None
    kind = _kind(blocks, strong[0])
    if len(kind.starts) > MOST or kind.decay > LONGEST or _follows_changes(blocks, kind):
        return None
    p_value = min(1.0, looked * float(gamma.sf(strong[0].power, len(channels))))
    return _event(kind, p_value)


def _blocks(t: np.ndarray, residual: np.ndarray, noise: np.ndarray, motion: Motion) -> Blocks:
    """Means of so many rows as make up a block; gaps in the stamps are passed over."""
    rows = max(1, round(1 / (RATE * float(np.median(np.diff(t))))))
    starts = np.arange(0, len(t) - rows + 1, rows)
    known = np.isfinite(residual) & (noise > 0)
    square = np.divide(1.0, noise**2, out=np.zeros(noise.shape), where=known)
    heard = np.where(known, residual, 0.0) * square
    cut = slice(0, len(starts) * rows)
    information, told = (each[cut].reshape(-1, rows, 6).sum(axis=1) for each in (square, heard))
    left = np.divide(told, information, out=np.zeros_like(told), where=information > 0)
    middle = t[cut].reshape(-1, rows).mean(axis=1)
    return Blocks(middle, left, np.sqrt(information), regimes_at(motion, middle))


def _follows_changes(blocks: Blocks, kind: Kind) -> bool:
    """Whether bursts come where the rate changes: what is left of the motion then is no burst."""
    among = blocks.regime[np.searchsorted(blocks.t, kind.starts).clip(0, len(blocks.t) - 1)]
    even = float((blocks.regime != CHANGES).mean())
    return bool((among != CHANGES).sum() < 0.5 * even * len(among))


def _kind(blocks: Blocks, strongest: Swing) -> Kind:
    """All bursts that swing as the strongest does, from its shape and then from theirs."""
    starts = np.array([strongest.start])
    frequencies = strongest.frequency * np.array([0.95, 1.0, 1.05])
    kind = _fitted(blocks, starts, frequencies, strongest.decay * np.array([0.5, 0.8, 1.2, 1.8]))
    for _ in range(ROUNDS):
        found = _further(blocks, kind)
        if len(found) == 0 or len(found) > MOST:
            break
        kind = _fitted(blocks, found, np.array([kind.frequency]), np.array([kind.decay]))
    return kind


def _fitted(
    blocks: Blocks, starts: np.ndarray, frequencies: np.ndarray, decays: np.ndarray
) -> Kind:
    """Shape and wave that bursts with these starts have in common."""
    longest = OVER * float(decays.max())
    last = np.searchsorted(starts, blocks.t, side="right") - 1
    age = np.where(last >= 0, blocks.t - starts[np.maximum(last, 0)], np.inf)
    rows = np.flatnonzero(age < longest)
    part = age[rows], blocks.left[rows], blocks.weight[rows]
    frequency, decay = shape_of(*part, frequencies, decays)
    wave, gain = fitted_waves(*part, frequency, decay)
    return Kind(starts, wave, gain, frequency, decay)


def _further(blocks: Blocks, kind: Kind) -> np.ndarray:
    """Starts (m,) s of all bursts that have the wave of a kind, to a fraction of a block."""
    step = float(np.median(np.diff(blocks.t)))
    age = np.arange(int(OVER * kind.decay / step)) * step
    course = (kind.wave * swings(age, kind.frequency, kind.decay)[:, None]).real
    squares = blocks.weight**2
    told = sum(_correlated(blocks.left[:, c] * squares[:, c], course[:, c]) for c in range(6))
    information = sum(_correlated(squares[:, c], course[:, c] ** 2) for c in range(6))
    told, information = np.asarray(told), np.maximum(np.asarray(information), 1e-30)
    size = told / information
    sure = told / np.sqrt(information)
    filled = int(FILLED * kind.decay / step)
    squares = (sure**2)[:, None]
    squares = without_louder(squares / np.maximum(levels(squares, blocks.regime) / 0.4549, 1.0),
                             blocks.regime, filled)  # fmt: skip
    sure = np.sign(sure) * np.sqrt(squares[:, 0])
    likely = np.where((size > ALIKE[0]) & (size < ALIKE[1]), sure, 0.0)
    likely[-max(1, int(kind.decay / step)) :] = 0.0  # too little is left of it to tell
    starts = []
    while likely.max() > SURE:
        top = int(likely.argmax())
        starts.append(blocks.t[top] + step * _summit(sure, top))
        likely[np.abs(blocks.t - blocks.t[top]) < 2 * kind.decay] = 0.0
        if len(starts) > MOST:
            break
    return np.sort(starts)


def _correlated(heard: np.ndarray, course: np.ndarray) -> np.ndarray:
    """Σ heard[k + j]·course[j], (m,), for each start k."""
    padded = np.concatenate([heard, np.zeros(len(course) - 1)])
    return np.asarray(correlate(padded, course, mode="valid", method="fft"))


def _summit(course: np.ndarray, top: int) -> float:
    """Where the parabola through a peak and its neighbours has its top, in steps from the peak."""
    if not 0 < top < len(course) - 1:
        return 0.0
    before, peak, after = course[top - 1 : top + 2]
    bend = before - 2 * peak + after
    return float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) if bend < 0 else 0.0


def _event(kind: Kind, p_value: float) -> Ringing:
    channels = tuple(int(c) for c in np.flatnonzero(kind.gain > SEEN**2))
    channels = channels or (int(kind.gain.argmax()),)
    wave = np.where(np.isin(np.arange(6), channels), kind.wave, 0.0)
    count, gain = len(kind.starts), float(kind.gain.sum())
    # Cramér and Rao: a fading swing tells its decay rate to √(2/gain) of it, and so its frequency.
    wide = float(np.sqrt(2 / gain))
    parameters = [
        FoundParameter(name="bursts", value=float(count), unit="1", u=0.0),
        FoundParameter(name="frequency", value=kind.frequency, unit="Hz",
                       u=wide / (2 * np.pi * kind.decay)),
        FoundParameter(name="decay", value=kind.decay, unit="s", u=wide * kind.decay),
    ]  # fmt: skip
    for channel in channels:
        size = float(np.abs(wave[channel]))
        parameters.append(
            FoundParameter(name=(GYRO + ACCEL)[channel], value=size, unit=UNITS[channel // 3],
                           u=size / float(np.sqrt(kind.gain[channel])))
        )  # fmt: skip
    return Ringing(
        "unnamed", channels, tuple(parameters), p_value, _said(kind, channels), None,
        kind.starts, np.tile(wave, (count, 1)), kind.frequency, kind.decay,
    )  # fmt: skip


def _said(kind: Kind, channels: tuple[int, ...]) -> Text:
    english, chinese = named(channels)
    when = ", ".join(f"{start:.0f}" for start in kind.starts[:8])
    when += ", …" if len(kind.starts) > 8 else ""
    swing = f"{kind.frequency:.3g} Hz"
    count = len(kind.starts)
    return (
        f"{count} bursts of {swing} that fade in {kind.decay:.2g} s, in the {english}, at {when} s",
        f"{count} 次 {swing} 的突发振荡，衰减时间 {kind.decay:.2g} s，通道：{chinese}，"
        f"时刻 {when} s",
    )
