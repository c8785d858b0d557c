"""What a recording cannot be: wrong units, axes and clocks, each told in one sentence.

By the means of the segments beside what the unit went through there, from encoders or from labels:
a matrix of what is read of each input, as a signed permutation times a factor. Only what fits a
usual mistake, and leaves next to nothing of the readings, is named; anything else is left to those
who search. Labels that are shifted as a whole are found by the rows that contradict them.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np

from schemas.recording import SI_PER_UNIT, Recording, Segment
from tasks.motion.whole import attitude_stream
from tasks.readings.axes import EXCITED, TriadMatrix
from tasks.readings.implausible import Implausible
from tasks.readings.label_shift import shift_of_labels
from tasks.readings.segment_means import (
    common_factor,
    directions_of,
    matrix_by_segments,
    matrix_of_directions,
    segment_means,
)
from tasks.readings.wrong_axes import wrong_axes
from tasks.readings.wrong_time import ways, wrong_time
from tasks.readings.wrong_units import (
    GAINS,
    wrong_forces,
    wrong_rates,
    wrong_rates_by_ways,
    wrong_table,
)
from tasks.words import message


def implausible(
    recording: Recording, segments: Sequence[Segment], read: np.ndarray | None = None
) -> tuple[Implausible, ...]:
    """What the recording cannot be, each in one sentence; nothing for a plausible one.

    segments: its labels, or what was found; read: (k, 6) means of all their rows, where each is
    measured and they are known.
    """
    scales = _units_of_source(recording)
    used = [s for s in segments if s.kind in ("static", "rate", "rotation")]
    if len(recording.imu) < 2:
        return ()
    means = segment_means(recording, used, read)
    if (wrong := wrong_time(recording, used, means)) is not None:
        return (wrong,)
    if not used:
        return ()
    gyro = matrix_by_segments(means.gyro, means.rate, EXCITED[0], forces=False)
    still = means.static & np.isfinite(means.up).all(axis=1)
    direction, removed = directions_of(means.accel), wrong_forces(recording, means, scales[1])
    is_removed = removed is not None and removed.kind == "gravity_removed"
    accel = None if is_removed else matrix_of_directions(direction[still], means.up[still])
    tracked = attitude_stream(recording) is not None and recording.table is None
    between_rests = partial(ways, recording, used, means)
    if not _is_usual(gyro) and (wrong := wrong_table(recording, means, between_rests)) is not None:
        return (wrong,)
    rates = wrong_rates(recording, gyro, scales[0])
    if gyro is None and not (means.rate[~means.static] != 0.0).any():
        rates = wrong_rates_by_ways(between_rests(), scales[0])
    found = [removed, rates]
    shifted = _shift(recording, gyro) if recording.manifest.segments else None
    mapped = None if tracked or shifted is not None else wrong_axes(gyro, accel)
    return tuple(one for one in (*found, shifted, mapped) if one is not None)


def _units_of_source(recording: Recording) -> tuple[float, float]:
    """rad/s and m/s² that one is of the units that the readings were imported from."""
    imported = (recording.manifest.model_extra or {}).get("imported")
    factors = imported.get(SI_PER_UNIT) if isinstance(imported, dict) else None
    if not isinstance(factors, dict):
        return 1.0, 1.0
    gyro, accel = (factors.get(triad, 1.0) for triad in ("gyro", "accel"))
    is_known = all(isinstance(one, int | float) and one > 0.0 for one in (gyro, accel))
    return (float(gyro), float(accel)) if is_known else (1.0, 1.0)


def _is_usual(gyro: TriadMatrix | None) -> bool:
    """Whether gyros read what the encoders or labels show, but for a range or a scale factor."""
    common = None if gyro is None else common_factor(gyro)
    return common is not None and GAINS[0] < common < GAINS[1]


def _shift(recording: Recording, gyro: TriadMatrix | None) -> Implausible | None:
    common = None if gyro is None else common_factor(gyro)
    found = shift_of_labels(recording, 1.0 if common is None or _is_usual(gyro) else common)
    if found is None:
        return None
    late = found.seconds < 0
    option = f"--shift {found.seconds:.2f}"
    return Implausible(
        "labels_shifted",
        message("plausibility-labels-shifted", seconds=f"{abs(found.seconds):.2f}",
                within=f"{found.within:.2f}", late="late" if late else "early", option=option),
        option,
    )  # fmt: skip
