"""States that remember the course of an input (rate, angle or specific force), row by row.

drive: (n,); NaN counts as no motion. Each state lies between −1 and 1, starts at 0 and keeps its
value while the drive stands still.
"""

from functools import lru_cache

import numpy as np

from tasks.motion.lag import first_order_lag


def signs(speed: np.ndarray, still: float) -> np.ndarray:
    """(n,) −1, 0 or 1: which way it moves; 0 where it is no faster than `still`."""
    known = np.nan_to_num(speed)
    return np.where(np.abs(known) > still, np.sign(known), 0.0)


def relaxed(speed: np.ndarray, step: np.ndarray, travel: float, still: float) -> np.ndarray:
    """The state goes to the sign of the motion within a travel (Dahl's friction).

    speed: (n,) of the drive; step: (n,) s since the row before. Within a motion of one sign
    s = sign − (sign − s₀)·e^(−ψ/travel), ψ travelled since its start.
    """
    sign = signs(speed, still)
    moved = np.cumsum(np.where(sign != 0.0, np.abs(np.nan_to_num(speed)) * step, 0.0))
    starts = np.flatnonzero(np.diff(sign, prepend=np.nan) != 0)
    ends = np.append(starts[1:], len(sign)) - 1
    before = np.where(starts > 0, moved[starts - 1], 0.0)
    kept = np.exp(-(moved[ends] - before) / travel)
    state, first = 0.0, np.zeros(len(starts))
    for n, (toward, stays) in enumerate(zip(sign[starts], kept, strict=True)):
        first[n] = state
        state = toward + (state - toward) * stays if toward else state
    length = ends - starts + 1
    began, since = np.repeat(first, length), moved - np.repeat(before, length)
    return np.where(sign != 0.0, sign + (began - sign) * np.exp(-since / travel), began)


def last_sign(speed: np.ndarray, still: float) -> np.ndarray:
    """The sign of the present or the last motion: a relay about zero."""
    sign = signs(speed, still)
    return _kept(sign, sign != 0.0)


def faded(speed: np.ndarray, t: np.ndarray, seconds: float, still: float) -> np.ndarray:
    """The sign of the last motion, forgotten in time while the drive stands still."""
    return last_sign(speed, still) * _forgotten(signs(speed, still) != 0.0, t, seconds)


def late_sign(speed: np.ndarray, t: np.ndarray, seconds: float, still: float) -> np.ndarray:
    """The sign of the motion through a lag of first order: learnt and forgotten in time."""
    return first_order_lag(signs(speed, still), float(np.median(np.diff(t))), seconds)


def last_peak(speed: np.ndarray, still: float) -> np.ndarray:
    """The fastest of the present or the last motion so far, with its sign, of the fastest of all.

    Preisach's relays, all of one threshold up and the same down, remember the same.
    """
    sign = signs(speed, still)
    size = np.abs(np.nan_to_num(speed)) * np.abs(sign)
    largest = float(size.max(initial=0.0))
    if not largest:
        return sign
    starts = np.flatnonzero(np.diff(sign, prepend=np.nan) != 0)
    peak = np.concatenate([np.maximum.accumulate(part) for part in np.split(size, starts[1:])])
    return _kept(sign * peak / largest, sign != 0.0)


def stopped(drive: np.ndarray, radius: float) -> np.ndarray:
    """The drive less its play of width 2·radius, over the radius (Prandtl's stop operator)."""
    return _stopped(np.ascontiguousarray(drive, float).tobytes(), radius)


@lru_cache(maxsize=64)  # a fit asks for the same drives and radii at each of its steps
def _stopped(drive_bytes: bytes, radius: float) -> np.ndarray:
    """(n,), not to be written to."""
    drive = np.frombuffer(drive_bytes)
    rows = np.flatnonzero(np.isfinite(drive))
    found = np.zeros(len(drive))
    change = np.diff(drive[rows], prepend=drive[rows[:1]])
    found[rows] = _clipped_sums(change, radius) / radius
    found.flags.writeable = False
    return found


def _clipped_sums(changes: np.ndarray, limit: float) -> np.ndarray:
    """(n,) sₖ = clip(sₖ₋₁ + changesₖ, ±limit) from s = 0.

    Clips of shifted sums, one after another, are again such a clip: so 2, 4, 8 … rows at once.
    """
    shift, low, high = changes.copy(), np.full(len(changes), -limit), np.full(len(changes), limit)
    reach = 1
    while reach < len(changes):
        late = shift[reach:].copy()
        shift[reach:] += shift[:-reach].copy()
        below, above = low[reach:].copy(), high[reach:].copy()
        low[reach:] = np.clip(low[:-reach] + late, below, above)
        high[reach:] = np.clip(high[:-reach] + late, below, above)
        reach *= 2
    return np.clip(shift, low, high)


def _kept(values: np.ndarray, new: np.ndarray) -> np.ndarray:
    """(n,) the last value of a row that is new; 0 before any."""
    last = np.maximum.accumulate(np.where(new, np.arange(len(values)), -1))
    return np.where(last >= 0, values[np.maximum(last, 0)], 0.0)


def _forgotten(moving: np.ndarray, t: np.ndarray, seconds: float) -> np.ndarray:
    """(n,) e^(−time since the last row that moves/seconds)."""
    return np.exp(-(t - _kept(t, moving)) / seconds)
