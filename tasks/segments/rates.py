"""The true rate of each turning segment: by the encoders, else by its label.

Without encoders the gyro itself is the only witness against a label. Its readings over all
points about an axis lie on one line (eq. (4)), whatever its scale factor; a label off that line
is contradicted.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from pydantic import ValidationError

from schemas.base import Unusable, first_fault
from schemas.laboratory import ErrorBound
from schemas.recording import AXES, Axis, Recording, Segment
from tasks.motion.table import mean_rate
from tasks.motion.whole import STEADINESS, agreeing_rate, doubt_of_angles
from tasks.readings.robust import TO_SIGMA, median
from tasks.segments.summarise import SegmentMean

# Which rate is the reference on a table whose angles are polled: theirs, or the commanded one.
#
# The times of polled angles are known to ± τ, so that a mean rate over T is uncertain by √2·τ/T.
# A table that holds the rate it is told to better than that is believed, where its angles agree.


def commanded_bound(recording: Recording) -> ErrorBound | None:
    """How far a held rate may be from the commanded one, relative; None where it is not said.

    Raises Unusable where the manifest's `table_time.commanded_rate` is no such bound.
    """
    stated = (recording.manifest.model_extra or {}).get("table_time")
    bound = stated.get("commanded_rate") if isinstance(stated, dict) else None
    try:
        return None if bound is None else ErrorBound.model_validate(bound)
    except ValidationError as error:
        raise Unusable(
            f"the manifest's table_time.commanded_rate: {first_fault(error)}; give half_width and "
            f"distribution, or leave it out"
        ) from error


def rate_by_command(recording: Recording, segment: Segment) -> np.ndarray | None:
    """The mean body rate (3,) rad/s of a held rate as commanded, about the axis that turns.

    None where the angles tell it better, or contradict it.
    """
    bound, seconds = commanded_bound(recording), segment.t_end - segment.t_start
    if bound is None or segment.kind != "rate":
        return None
    is_better = bound.half_width < doubt_of_angles(recording, seconds)
    return agreeing_rate(recording, segment) if is_better else None


OFF_LINE = 0.05  # of the rate: farther from the line, the label is another rate's
OFF_LINE_LEAST = np.radians(2.0)  # rad/s: a gyro bias is no other rate
PLAUSIBLE_SLOPES = (0.5, 2.0)  # scale factors that a gyro may have
SLOWEST_POINT = np.radians(0.05)  # rad/s: slower is a rest
FEWEST_BLOCKS = 6  # whose thirds have medians
READOUT = np.radians(0.01)  # rad/s: what an encoder's step makes of a rate


@dataclass(frozen=True)
class TurningPoint:
    """The whole input rate of one turning segment, with its sign about the labelled axis.

    rate: rad/s, NaN where the label is contradicted and there are no encoders.
    label: rad/s. shown: rad/s, what the witness shows; None without one.
    by_table: whether the encoders are the witness.
    contradicted, unsteady: what the witness says of the label and of the rate's steadiness.
    wander: rad/s, largest difference between the means of the segment's thirds.
    """

    rate: float
    label: float
    shown: float | None = None
    by_table: bool = False
    contradicted: bool = False
    unsteady: bool = False
    wander: float = 0.0


def turning_points(
    recording: Recording, segments: tuple[SegmentMean, ...]
) -> dict[int, TurningPoint]:
    """The turning point of every segment of kind rate, by its place in `segments`."""
    turning = {
        i: segment
        for i, segment in enumerate(segments)
        if segment.segment.kind == "rate" and segment.segment.axis and segment.segment.rate_deg_s
    }
    lines = [_line(turning, axis) for axis in AXES]
    points = {}
    for i, segment in turning.items():
        axis = AXES.index(segment.segment.axis)
        error = recording.rate_errors.get(segment.segment.name, 0.0)
        label = float(np.radians(segment.segment.rate_deg_s or 0.0)) / (1.0 + error)
        body = held_rate(recording, segment.segment)
        if body is not None:
            shown = float(np.copysign(np.linalg.norm(body), body[axis]))
            points[i] = _by_encoders(recording, segment, label, shown)
        else:
            points[i] = _by_gyro_and_label(segment, label, axis, lines[axis])
    return points


def held_rate(recording: Recording, segment: Segment) -> np.ndarray | None:
    """Mean body rate (3,) rad/s of a held rate by the encoders, None where there are none.

    Its amount is the commanded one where that is known better, and the angles do not contradict it.
    """
    commanded = rate_by_command(recording, segment)
    rate = mean_rate(recording, segment) if commanded is None else commanded
    if rate is None:
        return None
    return rate / (1.0 + recording.rate_errors.get(segment.name, 0.0))


def _input_rate(rate: float) -> float:
    """A rate as an input, NaN for one so slow that it is a rest."""
    return rate if abs(rate) >= SLOWEST_POINT else float("nan")


def _by_encoders(
    recording: Recording, segment: SegmentMean, label: float, shown: float
) -> TurningPoint:
    edges = np.linspace(segment.segment.t_start, segment.segment.t_end, 4).tolist()
    thirds = [
        held_rate(recording, segment.segment.model_copy(update={"t_start": start, "t_end": stop}))
        for start, stop in pairwise(edges)
    ]
    sizes = [float(np.linalg.norm(part)) for part in thirds if part is not None]
    wander = max(sizes) - min(sizes) if sizes else 0.0
    steps = READOUT * 30.0 / max(segment.seconds, 1e-3)
    doubt = doubt_of_angles(recording, segment.seconds) * abs(label)
    return TurningPoint(
        rate=_input_rate(shown),
        label=label,
        shown=shown,
        by_table=True,
        contradicted=abs(shown - label) > max(STEADINESS * abs(label), READOUT) + doubt,
        unsteady=wander > 2 * STEADINESS * abs(shown) + steps + 2 * 3 * doubt,
        wander=wander,
    )


def _by_gyro_and_label(
    segment: SegmentMean, label: float, axis: int, line: tuple[float, float]
) -> TurningPoint:
    if not segment.has_gyro:
        return TurningPoint(_input_rate(label), label)
    shown, (slope, offset) = float(segment.mean[axis]), line
    reach = max(OFF_LINE * abs(label) * slope, OFF_LINE_LEAST)
    contradicted = abs(shown - slope * label - offset) > reach
    wander = _wander(segment.blocks[axis])
    allowed = 4 * STEADINESS * abs(label) + 2 * READOUT
    return TurningPoint(
        rate=float("nan") if contradicted else _input_rate(label),
        label=label,
        shown=shown,
        contradicted=contradicted,
        unsteady=wander > allowed and wander > allowed + 6 * _noise_of_thirds(segment.blocks[axis]),
        wander=wander,
    )


def _line(turning: dict[int, SegmentMean], axis: Axis) -> tuple[float, float]:
    """Slope and offset (rad/s) of gyro against label about one axis, after Theil and Sen.

    The identity with fewer than three points, or where no unit has such a scale factor.
    """
    points = [s for s in turning.values() if s.segment.axis == axis and s.has_gyro]
    x = np.radians([s.segment.rate_deg_s or 0.0 for s in points])
    y = np.array([s.mean[AXES.index(axis)] for s in points])
    first, second = np.triu_indices(len(x), 1)
    apart = np.abs(x[second] - x[first]) > SLOWEST_POINT if len(x) else np.zeros(0, bool)
    if len(x) < 3 or not apart.any():
        return 1.0, 0.0
    slopes = (y[second] - y[first])[apart] / (x[second] - x[first])[apart]
    slope = float(np.median(slopes))
    if not PLAUSIBLE_SLOPES[0] < slope < PLAUSIBLE_SLOPES[1]:
        return 1.0, 0.0
    return slope, float(np.median(y - slope * x))


def _wander(blocks: np.ndarray) -> float:
    """Largest difference of the medians of the thirds of (blocks,) means; 0 for too few to tell."""
    if len(blocks) < FEWEST_BLOCKS:
        return 0.0
    medians = [float(median(part)) for part in np.array_split(blocks, 3)]
    return max(medians) - min(medians)


def _noise_of_thirds(blocks: np.ndarray) -> float:
    """Standard deviation of the median of a third of (blocks,) means, by their noise alone.

    From what neighbours differ by: a drift through the segment is no noise.
    """
    spread = TO_SIGMA * float(median(np.abs(np.diff(blocks)))) / np.sqrt(2.0)
    return spread * float(np.sqrt(4.7 / len(blocks)))
