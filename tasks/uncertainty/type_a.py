"""Type A uncertainty of segment means when the samples are not independent.

Each channel's noise is taken as white noise, flicker (1/f), random walk and a steady trend. White
noise is each segment's own; the strengths of the drift come from the Allan variances within the
segments and from what the means of all segments leave unexplained (`tasks.uncertainty.drift`).
The covariance of the segment means follows in closed form, so that drift between segments
counts, and what drift is common to two segments cancels in their difference.

Source: IEEE Std 952, annex C (Allan variances); the covariance of flicker noise and random walk
averaged over intervals is the double integral of the autocovariances h·E₁(|τ|/L), which is
S(f) = h/f above 1/(2πL), and −q·|τ|/2.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from schemas.calibration import Distribution
from schemas.recording import Up
from tasks.segments.summarise import SegmentMean, cosine_and_sine
from tasks.uncertainty.contrasts import contrasts
from tasks.uncertainty.drift import (
    DRIFTS,
    PooledAllan,
    drift_allan,
    drift_shapes,
    drift_strengths,
    seconds_of,
    white_of,
)

PER_DIFFERENCE = 0.8  # degrees of freedom of the white noise for each finest Allan difference
COARSE = 4.0  # Allan differences of a segment, at its two longest blocks, that flicker shows in
MIN_LENGTH = 0.5  # of the longest segment: shorter ones know less of drift, at other block lengths


@dataclass(frozen=True)
class ChannelNoise:
    """White noise and drift of the six channels.

    white: (segments, 6) variance of a mean over 1 s, unit²·s; of a rate point with what it is
        tilted for itself.
    drift: (DRIFTS, 6) flicker h of S(f) = h/f, unit², by where it ends (`drift.LEVELS`); random
        walk, unit²/s; slope², unit²/s².
    shapes: (DRIFTS, segments, segments) covariance of the segment means per unit of each drift.
    contrasts: (6,) how many independent contrasts between segments determine the drift.
    seconds: (segments,) their lengths. degrees: (segments,) degrees of freedom of the white noise.
    """

    white: np.ndarray
    drift: np.ndarray
    shapes: np.ndarray
    contrasts: np.ndarray
    seconds: np.ndarray
    degrees: np.ndarray

    @cached_property
    def drift_covariances(self) -> np.ndarray:
        """Covariances (6, segments, segments) of each channel's means by drift alone."""
        return np.tensordot(self.drift.T, self.shapes, axes=1)


def fit_noise(
    segments: tuple[SegmentMean, ...],
    up: tuple[Up | None, ...] | None = None,
    rate: np.ndarray | None = None,
) -> ChannelNoise:
    """White noise of each segment and drift of each channel.

    up, rate: the axis up and the rate (segments,) rad/s about its axis (NaN: not known) of each
    segment, where something knows them better than the labels.
    The white part is each segment's own (a turning table shakes), read off its Allan variances
    with the drift taken away; it is never less than the rounding of each row to one step.
    """
    if not segments:
        none, no_one = np.zeros((DRIFTS, 6)), np.zeros(0)
        shapes = np.zeros((DRIFTS, 0, 0))
        return ChannelNoise(np.zeros((0, 6)), none, shapes, np.zeros(6), no_one, no_one)
    if up is not None and rate is not None:
        segments = tuple(map(_corrected, segments, up, rate))
    white_only = _white(segments, np.zeros((DRIFTS, 6)))
    shapes = drift_shapes(segments)
    seconds = seconds_of(segments)
    white_variance = white_only / seconds[:, None]
    drift, count, tilted = np.zeros((DRIFTS, 6)), np.zeros(6), np.zeros_like(white_variance)
    known = np.array([np.isfinite(segment.allan).all(axis=0) for segment in segments])
    for channel in range(6):
        pooled = _pooled_allan([segments[i] for i in np.flatnonzero(known[:, channel])], channel)
        if pooled is not None:
            errors = contrasts(segments, shapes, white_variance[:, channel], channel)
            drift[:, channel] = drift_strengths(errors, pooled)
            count[channel] = errors.value.shape[1]
            tilted[:, channel] = errors.tilted
    white = _white(segments, drift) + tilted * seconds[:, None]
    return ChannelNoise(white, drift, shapes, count, seconds, _white_degrees(segments))


def covariance_of_means(noise: ChannelNoise, channel: int) -> np.ndarray:
    """Covariance (n, n) of one channel's segment means, unit².

    What it gives a bias is the uncertainty of its mean over all time where it flickers, over the
    recording itself where it walks or has a trend.
    """
    white = np.diag(noise.white[:, channel] / noise.seconds)
    return white + noise.drift_covariances[channel]


def type_a_dof(weights: np.ndarray, noise: ChannelNoise, channel: int, variance: float) -> float:
    """Effective degrees of freedom of the variance of o·U, Welch-Satterthwaite (GUM G.4).

    weights: o (n,) of all segment means; variance: of o·U in total. The white noise of a segment
    comes from its own B blocks: 0.8·(B − 1) degrees (by simulation, within 5 % from 4 blocks on).
    The drift comes from the residuals of all segments: as many degrees as there are independent
    contrasts between them (`drift.contrasts`), or, if there are none, four for each segment, the
    differences of its longest blocks. Everything else in the variance (thousands of angle readings)
    counts as known. Without any variance: infinitely many.
    """
    if variance <= 0.0:
        return math.inf
    used = np.flatnonzero(weights)
    white = weights[used] ** 2 * noise.white[used, channel] / noise.seconds[used]
    drifting = noise.drift_covariances[channel][np.ix_(used, used)]
    drift = max(float(weights[used] @ drifting @ weights[used]), 0.0)
    weight = float((white**2 / noise.degrees[used]).sum())
    if drift > 0.0:
        weight += drift**2 / (noise.contrasts[channel] or COARSE * len(noise.seconds))
    return max(variance**2 / weight, 1.0) if weight > 0.0 else math.inf


def _white_degrees(segments: tuple[SegmentMean, ...]) -> np.ndarray:
    """Those (n,) of the segments' own blocks; a turn has the median of the segments beside it."""
    degrees = np.array([PER_DIFFERENCE * (2.0 ** len(s.tau) - 1.0) for s in segments]).clip(1.0)
    moving = np.array([segment.segment.kind == "rotation" for segment in segments])
    if moving.any():
        degrees[moving] = np.median(degrees[~moving]) if not moving.all() else 1.0
    return degrees


def _corrected(segment: SegmentMean, up: Up | None, rate: float) -> SegmentMean:
    """A segment whose label says what is known of its inputs."""
    known = {"up": up, "rate_deg_s": float(np.degrees(rate)) if np.isfinite(rate) else None}
    return replace(segment, segment=segment.segment.model_copy(update=known))


def _pooled_allan(segments: list[SegmentMean], channel: int) -> PooledAllan | None:
    """Allan variances of the quiet ones among the longest segments, if they are not all zero.

    Of rests, where there are any: a turning axis that lies flat feels Earth's rotation and the
    table's tilt come and go, which would count as flicker.
    """
    measured = [s for s in segments if s.segment.kind != "rotation" and len(s.tau)]
    measured = [s for s in measured if s.segment.kind == "static"] or measured
    levels = max((len(s.tau) for s in measured), default=0)
    longest = max((s.seconds for s in measured), default=0.0)
    full = [s for s in measured if len(s.tau) == levels and s.seconds > MIN_LENGTH * longest]
    finest = np.array([s.allan[0, channel] for s in full])
    # A shaking turn would hide the flicker of the quiet segments under its white noise.
    if not full:
        return None
    quiet = [full[i] for i in np.flatnonzero(finest <= 3 * np.quantile(finest, 0.25))]
    variance = np.mean([s.allan[:, channel] for s in quiet], axis=0)
    tau = np.median([s.tau for s in quiet], axis=0)
    floor = np.mean([_rounding(s)[channel] for s in quiet]) / tau
    variance = np.maximum(variance, floor)
    return PooledAllan(variance, tau, len(quiet)) if variance.all() else None


def _white(segments: tuple[SegmentMean, ...], drift: np.ndarray) -> np.ndarray:
    """N² (segments, 6) of each segment: its Allan variances less the drift, never negative."""
    white = np.full((len(segments), 6), np.nan)
    for levels in {len(segment.tau) for segment in segments} - {0}:
        same = [i for i, segment in enumerate(segments) if len(segment.tau) == levels]
        tau = np.array([segments[i].tau for i in same])
        slow = np.tensordot(drift.T, drift_allan(tau), axes=1)
        allan = np.array([segments[i].allan.T for i in same])
        excess = white_of(allan - slow.swapaxes(0, 1), tau[:, None])
        white[same] = np.maximum(excess, [_rounding(segments[i]) for i in same])
    moving = np.array([segment.segment.kind == "rotation" for segment in segments])
    if moving.any():  # what varies there is the turn itself, not noise
        white[moving] = _median_known(white[~moving])
    return white


def _median_known(white: np.ndarray) -> np.ndarray:
    """Median over segments (6,), NaN for a channel that no segment has."""
    known = np.isfinite(white).any(axis=0) if len(white) else np.zeros(6, bool)
    median = np.full(6, np.nan)
    median[known] = np.nanmedian(white[:, known], axis=0)
    return median


def _rounding(segment: SegmentMean) -> np.ndarray:
    """N² (6,) that rounding each row to the channel's step gives."""
    return segment.step**2 / 12.0 * segment.seconds / segment.rows


# The distributions of input quantities: divisor, characteristic function, random draws.
#
# GUM 4.3 (JJF 1059.1-2012, Table 3) and JCGM 101:2008, 6.4. All are symmetric about the estimate.

# Half-width over standard uncertainty; a certificate's expanded uncertainty has k = 2.
DIVISORS = {
    "normal": 2.0,
    "rectangular": math.sqrt(3.0),
    "triangular": math.sqrt(6.0),
    "arcsine": math.sqrt(2.0),
}
NEGLIGIBLE = 1e-7  # of a characteristic function
NEARLY_NORMAL_DOF = 60.0  # from which a gamma variance moves the interval by 0.05 % at most
CHUNK = 60  # nodes that Student's t is worked out at before looking whether it has faded


def draw(
    distribution: Distribution, count: int, random: np.random.Generator, dof: float = math.inf
) -> np.ndarray:
    """Values (count,) with mean 0 and u = 1; `t` has scale 1 (6.4.9), so a larger deviation."""
    match distribution:
        case "normal":
            return random.standard_normal(count)
        case "t":
            return random.standard_t(dof, count)
        case "rectangular":
            values = random.uniform(-1.0, 1.0, count)
        case "triangular":
            values = random.triangular(-1.0, 0.0, 1.0, count)
        case "arcsine":
            values = np.sin(random.uniform(-math.pi, math.pi, count))
    return DIVISORS[distribution] * values


def characteristic_function(
    distribution: Distribution, s: np.ndarray, dof: float = math.inf
) -> np.ndarray:
    """φ at s > 0 of a distribution with standard uncertainty 1 (`t`: with scale 1)."""
    if distribution == "normal" or (distribution == "t" and math.isinf(dof)):
        return np.exp(-0.5 * s**2)
    if distribution == "t":
        return _student(s, dof)
    half_width = DIVISORS[distribution] * s
    if distribution == "rectangular":
        return np.asarray(cosine_and_sine(half_width)[1] / half_width)
    if distribution == "triangular":
        return (np.sin(0.5 * half_width) / (0.5 * half_width)) ** 2
    from scipy.special import j0

    return np.asarray(j0(half_width))


def _student(s: np.ndarray, dof: float) -> np.ndarray:
    if dof > NEARLY_NORMAL_DOF:  # normal with a variance ν/χ²: here gamma, of equal moments
        shape = (dof - 4.0) / 2.0
        return np.asarray((1.0 + dof / (dof - 2.0) / (2.0 * shape) * s**2) ** -shape)
    phi = np.zeros(len(s))
    for first in range(0, len(s), CHUNK):
        part = slice(first, first + CHUNK)
        phi[part] = _student_exactly(s[part], dof)
        if phi[part][-1] < NEGLIGIBLE:
            break
    return phi


def _student_exactly(s: np.ndarray, dof: float) -> np.ndarray:
    """K_{ν/2}(z)·z^{ν/2}/(Γ(ν/2)·2^{ν/2−1}) with z = √ν·s."""
    from scipy.special import gammaln, kve

    order, z = dof / 2.0, math.sqrt(dof) * s
    bessel = kve(order, z)
    finite = np.isfinite(bessel)  # it overflows next to zero, where the variance says it all
    phi = np.exp(-0.5 * dof / max(dof - 2.0, 1.0) * s**2)
    power = order * np.log(z[finite]) - z[finite] - gammaln(order) - (order - 1.0) * math.log(2.0)
    phi[finite] = bessel[finite] * np.exp(power)
    return phi
