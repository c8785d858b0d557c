"""Spikes and bursts: what disturbs some rows of a recording, named by nothing in the catalogue."""

import numpy as np
from scipy.stats import gamma, norm

from schemas.discrepancy import FoundParameter
from tasks.explain.events.event import Event, named
from tasks.motion.whole import Motion

FALSE_ALARM = 1e-4
FEWEST_SPIKES = 3
LARGE = 7.0  # of the noise: a reading that stands out so far from both its neighbours
CORNER = 10  # rows
STEADY = 0.02  # rad/s: how far the rate may move where it counts as steady
HOP = 200  # rows from one window to the next; a window is two of them
SLOWEST, FASTEST = 0.6, 6.0  # Hz of a burst
AWAY = 2  # windows after a move that may still settle
OUTSTANDS = 10.0  # times the power of the other windows between the same moves
FEWEST_WINDOWS = 6  # between two moves
RARE = 0.15  # share of the windows; what is in more of them is no burst


def find_spikes(
    residual: np.ndarray, noise: np.ndarray, motion: Motion
) -> tuple[Event | None, np.ndarray]:
    """Single readings far from both their neighbours, and which (n, 6) bool they are."""
    white = np.divide(residual, noise, out=np.full(residual.shape, np.nan), where=noise > 0)
    apart = np.zeros(residual.shape)
    apart[1:-1] = (white[1:-1] - 0.5 * (white[:-2] + white[2:])) / np.sqrt(1.5)
    far = (np.abs(apart) > LARGE) & _calm(motion.rate)[:, None]
    # A neighbour of a spike is far off as well, by less.
    peak = np.zeros(far.shape, bool)
    size = np.where(far, np.abs(apart), 0.0)
    peak[1:-1] = far[1:-1] & (size[1:-1] >= size[:-2]) & (size[1:-1] >= size[2:])
    at_rest = np.linalg.norm(motion.rate, axis=1) < STEADY
    rows: np.ndarray = np.asarray(peak.any(axis=1))
    spread = _spread(far)
    if rows.sum() < FEWEST_SPIKES:
        return None, spread
    channels = tuple(np.flatnonzero(peak.any(axis=0)).tolist())
    count = int(rows.sum())
    expected = far.size * 2 * norm.sf(LARGE)
    english, chinese = named(channels)
    turning = bool(at_rest.mean() > 0.05 and not (rows & at_rest).any())
    said = (
        f"{count} single readings stand out from their neighbours by more than {LARGE:.0f} times "
        f"the noise, in the {english}" + (", only while the table turns" if turning else ""),
        f"{count} 个孤立读数偏离相邻读数超过噪声的 {LARGE:.0f} 倍，通道：{chinese}"
        + ("，仅在转台转动时出现" if turning else ""),
    )
    parameters = (FoundParameter(name="spikes", value=float(count), unit="1", u=0.0),)
    p_value = float(min(1.0, expected**FEWEST_SPIKES))
    return Event("unnamed", channels, parameters, p_value, said, rows), spread


def _calm(rate: np.ndarray) -> np.ndarray:
    """Rows (n,) bool about which the rate does not change: a corner of a ramp is no spike."""
    calm = np.zeros(len(rate), bool)
    inside = slice(CORNER, -CORNER)
    change = np.abs(rate[2 * CORNER :] - rate[: -2 * CORNER]).max(axis=1, initial=0.0)
    calm[inside] = change < STEADY
    changes = np.convolve((~calm).astype(float), np.ones(2 * CORNER + 1), "same") > 0.5
    return ~changes


def _spread(far: np.ndarray) -> np.ndarray:
    """Rows that stand out and those beside them."""
    near = far.copy()
    near[1:] |= far[:-1]
    near[:-1] |= far[1:]
    return near


def find_bursts(
    t: np.ndarray, residual: np.ndarray, noise: np.ndarray, motion: Motion
) -> tuple[Event | None, np.ndarray]:
    """Short oscillations between moves, and the readings (n, 6) bool that they disturb."""
    masked = np.zeros(residual.shape, bool)
    channels = np.flatnonzero(np.isfinite(residual).any(axis=0))
    count = len(t) // HOP - 1
    if count < FEWEST_WINDOWS or len(channels) == 0:
        return None, masked
    steady = _steady(motion.rate, t, count)
    powers, frequencies = _powers(t, residual[:, channels], noise[:, channels], count)
    total = powers.sum(axis=2)  # (windows, bins)
    best = total.argmax(axis=1)
    tried = max(1, int(steady.sum()) * len(frequencies))
    threshold = gamma.isf(FALSE_ALARM / tried, len(channels))
    loud = steady & (total.max(axis=1) > threshold)
    loud &= _outstanding(total, best, loud, steady)
    if not loud.any() or loud.sum() > RARE * steady.sum():
        return None, masked
    hit = powers[loud, best[loud]].sum(axis=0) > gamma.isf(1e-3, loud.sum())
    seen = tuple(channels[hit].tolist())
    for window in np.flatnonzero(loud):
        masked[window * HOP : (window + 2) * HOP, list(seen)] = True
    power = total[loud].max(axis=1)
    at = frequencies[best[loud]]
    middle = float(np.average(at, weights=power))
    u = max(float(np.std(at)), float(frequencies[1] - frequencies[0])) / np.sqrt(loud.sum())
    starts = np.flatnonzero(loud & ~np.concatenate([[False], loud[:-1]]))
    when = ", ".join(f"{t[start * HOP]:.0f}" for start in starts[:8])
    when += ", …" if len(starts) > 8 else ""
    english, chinese = named(seen)
    said = (
        f"{len(starts)} short bursts of about {middle:.2g} Hz in the {english}, at {when} s",
        f"{len(starts)} 次约 {middle:.2g} Hz 的短时突发，通道：{chinese}，时刻 {when} s",
    )
    parameters = (
        FoundParameter(name="bursts", value=float(len(starts)), unit="1", u=0.0),
        FoundParameter(name="frequency", value=middle, unit="Hz", u=float(u)),
    )
    p_value = min(1.0, float(tried * gamma.sf(power.max(), len(channels))))
    rows: np.ndarray = np.asarray(masked.any(axis=1))
    return Event("unnamed", seen, parameters, p_value, said, rows), masked


def _windows(rows: np.ndarray, count: int) -> np.ndarray:
    """Windows (count, 2·HOP, ...) of rows, each half a window after the one before."""
    hops = rows[: (count + 1) * HOP].reshape(count + 1, HOP, *rows.shape[1:])
    return np.concatenate([hops[:-1], hops[1:]], axis=1)


def _steady(rate: np.ndarray, t: np.ndarray, count: int) -> np.ndarray:
    """Windows (count,) bool in and shortly before which the rate does not change."""
    calm = np.ptp(_windows(rate, count), axis=1).max(axis=1) < STEADY
    apart = np.diff(_windows(t, count), axis=1)
    calm &= apart.max(axis=1) < 1.5 * np.median(apart)
    steady = calm.copy()
    for back in range(1, AWAY + 1):
        steady[back:] &= calm[:-back]
    steady[:AWAY] = False
    return steady


def _powers(
    t: np.ndarray, residual: np.ndarray, noise: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Power over that of white noise (windows, bins, channels) and frequencies, Hz."""
    cut = _windows(np.nan_to_num(residual / noise), count)
    course = np.linspace(-1.0, 1.0, 2 * HOP)
    drift, _ = np.linalg.qr(np.polynomial.polynomial.polyvander(course, 3))
    cut = cut - np.einsum("nk,wkc->wnc", drift, np.einsum("nk,wnc->wkc", drift, cut))
    frequencies = np.fft.rfftfreq(2 * HOP, float(np.median(np.diff(t))))
    inside = (frequencies >= SLOWEST) & (frequencies <= FASTEST)
    spectrum = np.fft.rfft(cut, axis=1)[:, inside]
    return np.abs(spectrum) ** 2 / (2 * HOP), frequencies[inside]


def _outstanding(
    total: np.ndarray, best: np.ndarray, loud: np.ndarray, steady: np.ndarray
) -> np.ndarray:
    """Which loud windows stand out from the others between the same two moves."""
    stands = np.zeros(len(loud), bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], steady, [False]]).astype(int)))
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        if stop - start < FEWEST_WINDOWS:
            continue
        for window in start + np.flatnonzero(loud[start:stop]):
            others = np.median(total[start:stop, best[window]])
            stands[window] = total[window, best[window]] > OUTSTANDS * others
    return stands
