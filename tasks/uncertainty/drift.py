"""How much each channel drifts over a recording, from what its segment means leave unexplained.

Within a segment, noise hides a drift that is slower than the segment; between segments it shows,
once rates, gravity and the horizontal parts of Earth's rotation and of the tilt are fitted away.
The likelihood of what is left is that of restricted maximum likelihood (Patterson and Thompson,
Biometrika 58, 1971), in the contrasts that diagonalise flicker; walk and trend are taken as
diagonal there too, which they nearly are. The Allan variances within the segments join it.
A drift that a short recording hides is not zero: the strengths are means over the likelihood.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import get_args

import numpy as np

from schemas.recording import AXES, Up
from tasks.segments.summarise import SegmentMean

UPS: tuple[Up, ...] = get_args(Up)
SHAPES = 3  # flicker, random walk, trend
FLICKER_ALLAN = 2.0 * np.log(2.0)  # Allan variance of flicker noise, per unit of h
UNSEEN = 10.0  # spans of the recording over which the flicker's part of the bias is the mean
FEWEST_CONTRASTS = 4
MOST_DEGREES = 100.0  # no Allan variance counts more: the shapes are not exact
WHOLE_TURN = 0.1  # what may be left of a horizontal field after the turns of one rate run
FAINTEST = 0.1  # of the white noise, in the contrast that shows the drift best
NONE = 20.0  # e-folds of strength that no drift at all is worth beforehand
STEPS = 9  # strengths of a drift on each of two grids
INSTANT = 1e-3  # s: a segment of one row has no length


@dataclass(frozen=True)
class Contrasts:
    """Independent combinations of the segment means that rates, gravity and bias leave alone.

    value: (m,) over the standard deviation that white noise gives each.
    gain: (SHAPES, m) variance per unit of each drift's strength, in units of the white one.
    """

    value: np.ndarray
    gain: np.ndarray


@dataclass(frozen=True)
class PooledAllan:
    """Mean Allan variances (levels,) of `segments` segments at block lengths tau (levels,) s."""

    variance: np.ndarray
    tau: np.ndarray
    segments: int

    @property
    def white(self) -> float:
        return float(white_of(self.variance, self.tau))

    @property
    def degrees(self) -> np.ndarray:
        """How much each level counts in the likelihood."""
        return np.minimum(MOST_DEGREES, _differences(len(self.tau)) * self.segments)


def drift_shapes(segments: tuple[SegmentMean, ...]) -> np.ndarray:
    """Covariance (SHAPES, n, n) of the segment means per unit of flicker, walk and trend.

    Flicker h (S(f) = h/f) is counted about the mean over UNSEEN spans of the recording; a random
    walk q (variance per second) and a trend (slope squared) about the mean of this run.
    """
    start = np.array([segment.t_start for segment in segments])
    stop = np.array([max(s.t_end, s.t_start + INSTANT) for s in segments])
    first, last = start.min(), stop.max()
    flicker = np.log(UNSEEN * (last - first)) - 1.5 - _mean_log_distance(start, stop)
    apart = _mean_distance(np.append(start, first), np.append(stop, last))
    to_run = apart[:-1, -1]
    walk = 0.5 * (to_run[:, None] + to_run[None, :] - apart[:-1, :-1] - apart[-1, -1])
    middle = 0.5 * (start + stop - first - last)
    return np.array([flicker, walk, np.outer(middle, middle)])


def drift_allan(tau: np.ndarray) -> np.ndarray:
    """Allan variance (SHAPES, levels) per unit of each drift's strength (IEEE Std 952, C)."""
    return np.array([np.full(len(tau), FLICKER_ALLAN), tau / 3.0, tau**2 / 2.0])


def contrasts(
    segments: tuple[SegmentMean, ...], shapes: np.ndarray, variance: np.ndarray, channel: int
) -> Contrasts:
    """What one channel's means (white variances (n,)) say of its drift, with the rest removed."""
    used = [
        i
        for i, segment in enumerate(segments)
        if _is_known(segment, channel) and np.isfinite(segment.mean[channel]) and variance[i] > 0
    ]
    nothing = Contrasts(np.zeros(0), np.zeros((SHAPES, 0)))
    if not used:
        return nothing
    scale = 1.0 / np.sqrt(variance[used])
    design = _design([segments[i] for i in used], channel) * scale[:, None]
    size = np.linalg.norm(design, axis=0)
    left, weight, _ = np.linalg.svd(design[:, size > 0] / size[size > 0])
    free = left[:, (weight > 1e-9 * weight[0]).sum() :]
    if free.shape[1] < FEWEST_CONTRASTS:
        return nothing
    means = np.array([segments[i].mean[channel] for i in used])
    seen = free.T @ (shapes[:, used][:, :, used] * scale[:, None] * scale) @ free
    modes = np.linalg.eigh(seen[0])[1]
    gain = (modes * (seen @ modes)).sum(axis=1)
    return Contrasts(modes.T @ (free.T @ (means * scale)), gain.clip(min=0.0))


def drift_strengths(seen: Contrasts, allan: PooledAllan) -> np.ndarray:
    """Mean strength (SHAPES,) of flicker, walk and trend over their likelihood.

    Without contrasts between segments the Allan variances know of flicker only. The first, wide
    grid finds where the second, fine one has to be.
    """
    shown = SHAPES if len(seen.value) else 1
    grids = [_wide_grid(seen, allan, shape) for shape in range(shown)]
    grids = [_closer(*pair) for pair in zip(grids, _marginals(grids, seen, allan), strict=True)]
    chances = _marginals(grids, seen, allan)
    strengths = [float(grid @ chance) for grid, chance in zip(grids, chances, strict=True)]
    return np.array(strengths + [0.0] * (SHAPES - shown))


def white_of(allan: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """N² (…) of Allan variances (…, levels): times τ, averaged, as each level knows it."""
    degrees = _differences(len(tau))
    return (allan * tau) @ degrees / degrees.sum()


def _differences(levels: int) -> np.ndarray:
    """Neighbouring blocks that each Allan variance compares, finest first."""
    return 2.0 ** np.arange(levels, 0, -1) - 1


def _wide_grid(seen: Contrasts, allan: PooledAllan, shape: int) -> np.ndarray:
    """Nothing, and strengths from what hides under the white noise to more than all there is."""
    largest = 3.0 * float(allan.variance.max()) / FLICKER_ALLAN if shape == 0 else 0.0
    faintest = 0.01 * FAINTEST * allan.white / allan.tau[-1]
    if len(seen.value):
        gain = seen.gain[shape]
        faintest = FAINTEST / gain.max()
        largest = max(largest, 10.0 * float(seen.value @ seen.value / gain.sum()))
    return np.append(0.0, np.geomspace(faintest, max(largest, 10.0 * faintest), STEPS))


def _closer(grid: np.ndarray, chance: np.ndarray) -> np.ndarray:
    """As many strengths where the likelihood is."""
    likely = np.flatnonzero(chance[1:] > 1e-3 * chance.max()) + 1
    low, high = (likely[0], likely[-1]) if len(likely) else (1, 1)
    fine = np.geomspace(grid[max(low - 1, 1)], grid[min(high + 1, len(grid) - 1)], STEPS)
    return np.append(0.0, fine)


def _marginals(grids: list[np.ndarray], seen: Contrasts, allan: PooledAllan) -> list[np.ndarray]:
    """Probability of each strength of a grid, whatever the others are."""
    strength = np.array(np.meshgrid(*grids, indexing="ij"))
    shown = len(grids)
    known = np.moveaxis(strength, 0, -1)
    slow = known @ drift_allan(allan.tau)[:shown]
    white = np.maximum(white_of(allan.variance - slow, allan.tau), 1e-3 * allan.white)
    expected = white[..., None] / allan.tau + slow
    likelihood = -0.5 * (np.log(expected) + allan.variance / expected) @ allan.degrees
    if len(seen.value):
        spread = known @ seen.gain[:shown] + (white / allan.white)[..., None]
        likelihood -= 0.5 * (np.log(spread) + seen.value**2 / spread).sum(axis=-1)
    chance = np.exp(likelihood - likelihood.max())
    for shape, grid in enumerate(grids):
        step = np.log(grid[2] / grid[1])
        prior = np.append(NONE, np.full(len(grid) - 1, step))
        chance = chance * prior.reshape([-1 if j == shape else 1 for j in range(shown)])
    chance /= chance.sum()
    axes = range(shown)
    return [chance.sum(axis=tuple(j for j in axes if j != shape)) for shape in axes]


def _is_known(segment: SegmentMean, channel: int) -> bool:
    """Whether a segment's inputs are known to the level of a bias.

    A turn about a gyro's own axis is not: the table's rate and the straightness of the line come
    in. Nor is a run over few turns, in which Earth's rotation and the tilt do not average out.
    """
    label = segment.segment
    if label.up is None or label.kind == "rotation":
        return False
    if label.kind == "static":
        return True
    if label.rate_deg_s is None or label.axis == dict(enumerate(AXES)).get(channel):
        return False
    return bool(abs(np.sinc(label.rate_deg_s * segment.seconds / 360.0)) < WHOLE_TURN)


def _design(segments: list[SegmentMean], channel: int) -> np.ndarray:
    """Columns (n, …) of what moves a channel's mean without drift: bias, gravity, turning, field.

    The horizontal parts of Earth's rotation (gyro) and of gravity by tilt (accelerometer) reach
    the channels that lie flat, by the heading of the rest; where it is not told, anything goes.
    """
    columns = [np.ones(len(segments))]
    for axis in AXES:
        about = np.array([s.segment.rate_deg_s or 0.0 if s.segment.axis == axis else 0.0
                          for s in segments]) / 100.0  # fmt: skip
        columns += [np.array([(s.segment.up == f"+{axis}") - float(s.segment.up == f"-{axis}")
                              for s in segments]), about**2]  # fmt: skip
        if channel < len(AXES):
            columns.append(about)
    labels = [segment.segment for segment in segments]
    flat = [s.kind == "static" and (s.up or "")[1:] != AXES[channel % 3] for s in labels]
    for i, label in enumerate(labels):
        if flat[i] and label.turn_deg is None:
            columns.append(np.eye(len(labels))[i])
    for up in UPS:
        held = np.array([f and s.up == up for f, s in zip(flat, labels, strict=True)])
        told = held * np.array([s.turn_deg is not None for s in labels])
        heading = np.radians([s.turn_deg or 0.0 for s in labels])
        columns += [told * np.cos(heading), told * np.sin(heading).round(9)]
    return np.column_stack(columns)


def _mean_log_distance(start: np.ndarray, stop: np.ndarray) -> np.ndarray:
    """Mean of ln|t − s| over t in interval i and s in interval j, (n, n)."""
    return _mean_of(
        lambda x: 0.5 * x**2 * np.log(np.where(x > 0, x, 1.0)) - 0.75 * x**2, start, stop
    )


def _mean_distance(start: np.ndarray, stop: np.ndarray) -> np.ndarray:
    """Mean of |t − s| over t in interval i and s in interval j, (n, n)."""
    return _mean_of(lambda x: x**3 / 6.0, start, stop)


def _mean_of(
    second_integral: Callable[[np.ndarray], np.ndarray], start: np.ndarray, stop: np.ndarray
) -> np.ndarray:
    """Mean over two intervals of a function of |t − s| that has this second integral."""
    a, b = start[:, None], stop[:, None]
    c, d = start[None, :], stop[None, :]
    total = second_integral(np.abs(b - c)) + second_integral(np.abs(a - d))
    total -= second_integral(np.abs(b - d)) + second_integral(np.abs(a - c))
    return total / ((b - a) * (d - c))
