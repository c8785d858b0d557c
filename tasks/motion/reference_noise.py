"""Errors of the reference, estimated from itself, in what it predicts of each reading.

Of encoders: noise, steps and the jitter of their stamps show in the sixth differences of the
angle, stretch by stretch, so that an axis that rests is exact and one that turns is as good as its
encoder; a corner of the motion is rare among them and does not count. A stretch with one step is no
better than the step, and scatter of the stamps counts by the rate. Of poses: what the smoothing
takes away. All are white from reading to reading, and become noise of rates by the same kernels as
the angles.
"""

from dataclasses import dataclass

import numpy as np

from schemas.recording import Recording, Stream
from tasks.motion.pose import Tracking
from tasks.motion.reported_rate import reported_rate
from tasks.motion.samples import NORMAL_QUANTILES, in_blocks, noise_by_differences
from tasks.motion.smooth import ROUNDING, even_grid, rate_kernel
from tasks.motion.whole import Motion, attitude_stream

NODE = 64  # samples that a noise is read off
ORDER, DIFFERENCE = 6, float(np.sqrt(924.0))  # and what it makes of white noise
WHOLE, MOSTLY = 0.1, 0.9  # steps: changes that are mostly whole ones within this are quantised
FEW_STEPS = 20.0  # more are whole within rounding whatever they are


@dataclass(frozen=True)
class EncoderNoise:
    """Variance (m, k) rad² of a reading of each table axis about times t (m,) s.

    kernel: per sample, of the rate; interval: s. reported: (k,) bool, the rate is not the angle's.
    """

    t: np.ndarray
    variance: np.ndarray
    kernel: np.ndarray
    interval: float
    reported: np.ndarray


@dataclass(frozen=True)
class ReferenceNoise:
    """Either of encoders or of poses; neither: of labels, which are exact or wrong."""

    encoders: EncoderNoise | None = None
    tracking: Tracking | None = None

    def variance(self, motion: Motion, width: float) -> np.ndarray:
        """(n, 6) (rad/s)² and (m/s²)² of predicted readings that are means over `width` s."""
        found = np.zeros((len(motion.t), 6))
        if self.tracking is not None:
            found[:, :3] = self.tracking.rate_variance(width)
            found[:, 3:] = self.tracking.force_variance(width, motion.gravity)
        if self.encoders is not None and motion.axes is not None:
            noise = self.encoders
            angle = np.column_stack([np.interp(motion.t, noise.t, v) for v in noise.variance.T])
            box = max(1, round(width / noise.interval))
            mean = np.convolve(noise.kernel, np.full(box, 1.0 / box))
            rate = angle * float((mean**2).sum()) / noise.interval**2 * ~noise.reported
            directions = motion.axes.directions
            found[:, :3] = np.einsum("nk,nki->ni", rate, directions**2)
            leaning = motion.gravity * np.cross(directions, motion.up[:, None, :])
            found[:, 3:] = np.einsum("nk,nki->ni", angle / box, leaning**2)
        return np.nan_to_num(found)

    def since(self, start: float) -> "ReferenceNoise":
        """The same with times from another origin, s."""
        if self.encoders is None:
            return self
        one = self.encoders
        moved = EncoderNoise(one.t - start, one.variance, one.kernel, one.interval, one.reported)
        return ReferenceNoise(moved, self.tracking)


EXACT = ReferenceNoise()


def reference_noise(recording: Recording, motion: Motion) -> ReferenceNoise:
    """The errors of whatever gives the recording's motion."""
    stream = attitude_stream(recording)
    if motion.tracking is not None or stream is None or stream is not recording.table:
        return ReferenceNoise(tracking=motion.tracking)
    return ReferenceNoise(_encoder_noise(recording, stream))


def _encoder_noise(recording: Recording, table: Stream) -> EncoderNoise | None:
    axes = recording.manifest.station.table_axes or ()
    angles = np.unwrap(table.stack(tuple(f"{axis.name}_angle" for axis in axes)), axis=0)
    if len(angles) < 2 * NODE:
        return None
    steps = np.array([_step(course) for course in np.abs(np.diff(angles, axis=0)).T])
    t, even = even_grid(table.t, angles)
    interval = float(t[1] - t[0])
    changes = np.abs(np.diff(even, axis=0))
    size, moved = _size(even), in_blocks(changes[ORDER - 1 :], NODE) > ROUNDING
    # A single change tells its place to within one step: the rate there is as uncertain as any.
    variance = np.maximum(size**2, moved.any(axis=1) * steps**2 / 12.0)
    if (size.mean(axis=0) > _size(angles).mean(axis=0)).any():
        # The samples are even and their stamps are not: interpolation hides most of it.
        jitter = noise_by_differences(table.t, 2, 0.5) * np.sqrt(len(t) / len(angles))
        speed = np.median(in_blocks(changes[ORDER - 1 :], NODE), axis=1) / interval
        variance = np.maximum(variance, (speed * jitter) ** 2)
    middles = in_blocks(t[ORDER // 2 :], NODE)[: len(variance)].mean(axis=1)
    reported = np.array([reported_rate(table, axis.name) is not None for axis in axes])
    return EncoderNoise(middles, variance, rate_kernel(even, interval), interval, reported)


def _size(angles: np.ndarray) -> np.ndarray:
    """Standard deviation (m, k) rad of the white noise of angles (n, k) in each stretch."""
    rough = in_blocks(np.abs(np.diff(angles, ORDER, axis=0)), NODE)
    return np.asarray(np.median(rough, axis=1) / NORMAL_QUANTILES[0.5] / DIFFERENCE)


def _step(changes: np.ndarray) -> float:
    """The encoder's step, rad; 0 where its changes are not whole steps."""
    moved = changes[changes > ROUNDING]
    if not len(moved):
        return 0.0
    least = float(np.quantile(moved, 0.01))
    few = moved[moved < FEW_STEPS * least] / least
    whole = np.abs(few - np.round(few)) < WHOLE
    return least if whole.mean() > MOSTLY else 0.0
