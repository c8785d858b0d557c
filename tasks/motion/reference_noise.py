"""Errors of the reference, estimated from itself, as errors of each predicted reading.

Of encoders: what the noise of their angles leaves in the rates made of them. Of poses: what
the smoothing takes away.
"""

from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import Recording, Stream
from tasks.motion.encoders import NODE, EncoderRate, encoder_steps, smooth_course
from tasks.motion.pose import Tracking
from tasks.motion.whole import Motion, attitude_stream, reported_rate


@dataclass(frozen=True)
class EncoderNoise:
    """Variance (m, k) rad² of a reading of each table axis at times t (m,) s.

    rate: of the rate derived from the readings. reported: (k,) bool, the rate is reported, not that
    of the angle. steps: (k,) rad, 0 for an encoder without; the rounding of a rest shows in no
    scatter. span: s between the two angles that give a mean rate; 0: it is `rate`.
    """

    t: np.ndarray
    variance: np.ndarray
    rate: EncoderRate
    reported: np.ndarray
    steps: np.ndarray
    span: float = 0.0

    @property
    def of_rests(self) -> np.ndarray:
        """Variance (m, k) rad² of the mean angle of a rest: of its rounding, which is the same
        throughout unless noise moves the readings from code to code (Widrow and Kollár,
        Quantization Noise, 2008, 4.6).
        """
        rounding = self.steps**2 / 12.0
        moving = (
            np.maximum(self.variance - rounding, 0.0) / np.where(rounding, self.steps, 1.0) ** 2
        )
        return np.asarray(rounding * np.exp(-4.0 * np.pi**2 * moving) * self.rate.at_rest)

    def of_mean_rate(self, width: float) -> np.ndarray:
        """Variance (m, k) (rad/s)² of rates that are means over `width` s."""
        if self.span:
            # Neighbours share an angle with opposite signs: of longer means it is an upper bound.
            return np.asarray(2.0 * self.variance / self.span**2)
        return self.rate.variance_of_mean(width) * ~self.reported


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
            box = max(1, round(width / noise.rate.interval))
            angle, rate, rounding = (
                np.column_stack([np.interp(motion.t, noise.t, v) for v in variance.T])
                for variance in (noise.variance, noise.of_mean_rate(width), noise.of_rests)
            )
            directions = motion.axes.directions
            found[:, :3] = np.einsum("nk,nki->ni", rate, directions**2)
            for k in range(1, angle.shape[1]):  # what carries an axis turns by its angle
                carried = np.cross(directions[:, k], motion.axes.outside(k))
                found[:, :3] += (angle[:, k] / box + rounding[:, k])[:, None] * carried**2
            leaning = motion.gravity * np.cross(directions, motion.up[:, None, :])
            found[:, 3:] = np.einsum("nk,nki->ni", angle / box, leaning**2)
        return np.nan_to_num(found)

    def since(self, start: float) -> "ReferenceNoise":
        """The same with times from another origin, s."""
        if self.encoders is None:
            return self
        return ReferenceNoise(replace(self.encoders, t=self.encoders.t - start), self.tracking)


EXACT = ReferenceNoise()


def reference_noise(recording: Recording, motion: Motion) -> ReferenceNoise:
    """The errors of whatever gives the recording's motion."""
    stream = attitude_stream(recording)
    if motion.tracking is not None or stream is None or stream is not recording.table:
        return ReferenceNoise(tracking=motion.tracking)
    return ReferenceNoise(_encoder_noise(recording, stream))


def _encoder_noise(recording: Recording, table: Stream) -> EncoderNoise | None:
    axes = recording.manifest.station.table_axes or ()
    course = smooth_course(table, tuple(f"{axis.name}_angle" for axis in axes))
    if course is None or len(table) < 2 * NODE:
        return None
    reported = np.array([reported_rate(table, axis.name) is not None for axis in axes])
    return EncoderNoise(
        course.even, course.variance, course.slope, reported, encoder_steps(course.angle),
        recording.imu.span,
    )  # fmt: skip
