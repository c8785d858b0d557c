"""What JJF 1536 needs beside the evidence of every recording: attitudes, turns, angle noise."""

from dataclasses import dataclass

import numpy as np

from schemas.recording import AXES
from tasks.segments.summarise import SegmentMean
from tasks.specifications.evidence import Evidence
from tasks.uncertainty.type_a import covariance_of_means

SCALE_ITEMS = ("scale_factor", "rate_sensitivity")  # rests with these labels are no positions

OTHER_RATE = np.radians(2.0)  # rad/s: a zero offset is no other rate


@dataclass(frozen=True, kw_only=True)
class AhrsEvidence(Evidence):
    """Evidence with what JJF 1536 needs beside it.

    attitude: (3, 15) of each rest (`attitudes.attitude_vector`), None where it is not known and
    where it turns. contradicted: rests whose label has another attitude than table and mount.
    turned: rad, angle of each of the `turns`; turn_rate: deg/s in its middle.
    angle_noise: (3,) rad², variance of one reading of the angle; 0 for rates.
    by_angle: whether the rates are increments of accumulated angles.
    """

    attitude: tuple[np.ndarray | None, ...]
    contradicted: frozenset[int]
    turned: dict[int, float]
    turn_rate: dict[int, float]
    angle_noise: np.ndarray
    by_angle: bool

    def noise_covariance(self, channel: int) -> np.ndarray:
        """Covariance (n, n) of one channel's mean rates: rate noise, drift, and angle noise.

        A mean rate is the difference of two readings of the angle over the time; segments that
        share a reading share its error, with opposite signs.
        """
        rate = covariance_of_means(self.segments, self.noise, channel)
        return rate + self.angle_noise[channel] * _shared_readings(self.segments)


def _shared_readings(segments: tuple[SegmentMean, ...]) -> np.ndarray:
    """Covariance (n, n), 1/s², of mean rates per unit variance of one angle reading."""
    seconds = np.array([segment.seconds for segment in segments])
    start = np.array([segment.t_start for segment in segments])
    end = np.array([segment.t_end for segment in segments])
    same = 1.0 * (start[:, None] == start) + 1.0 * (end[:, None] == end)
    opposite = 1.0 * (start[:, None] == end) + 1.0 * (end[:, None] == start)
    return (same - opposite) / np.outer(seconds, seconds)


def reads_another_rate(segment: SegmentMean, rate: float) -> bool:
    """Whether the axis that label or mount says was turned reads something else altogether.

    rate: rad/s, by the table or the label. No scale factor is below a half or above two.
    """
    axis = segment.segment.axis
    read = segment.mean[AXES.index(axis)] if axis else np.nan
    reach = max(0.5 * abs(rate), OTHER_RATE)
    return bool(abs(read - rate) > reach and not 0.5 < read / rate < 2.0)


def is_zero_position(segment: SegmentMean) -> bool:
    """Whether a rest belongs to 7.2: every rest but those beside the rate runs and the turns."""
    label = segment.segment
    return label.kind == "static" and label.item not in (*SCALE_ITEMS, "misalignment")
