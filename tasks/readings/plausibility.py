"""What is found of a recording on sight, once, for import, calibration, validity and explanation.

Wrong units, axes and clocks, columns that are no reading, rows that are held, a log too coarse.

By the means of the segments beside what the unit went through there, from encoders or from labels:
a matrix of what is read of each input, as a signed permutation times a factor. Only what fits a
usual mistake, and leaves next to nothing of the readings, is named; anything else is left to those
who search. Labels that are shifted as a whole are found by the rows that contradict them.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import partial

import numpy as np
from pydantic import TypeAdapter, ValidationError

from schemas.recording import SEEN, SI_PER_UNIT, Recording, Segment
from schemas.text import Remark, Seen
from tasks.motion.angle_rates import gives_angles
from tasks.motion.whole import attitude_stream
from tasks.readings.axes import EXCITED, TriadMatrix
from tasks.readings.implausible import found_on_sight
from tasks.readings.label_shift import shift_of_labels
from tasks.readings.segment_means import (
    common_factor,
    directions_of,
    matrix_by_segments,
    matrix_of_directions,
    responses,
    segment_means,
    sizes_beside_poses,
    sizes_by_rates,
)
from tasks.readings.standing import coarse_remarks, held_remarks
from tasks.readings.wrong_axes import columns_of_others, turned_aslant, wrong_axes
from tasks.readings.wrong_time import ways, wrong_time
from tasks.readings.wrong_units import (
    GAINS,
    wrong_forces,
    wrong_labels,
    wrong_rates,
    wrong_rates_by_ways,
    wrong_table,
)
from tasks.words import message

SEEN_IN_FILE = TypeAdapter(tuple[Seen, ...])


def on_sight(
    recording: Recording, segments: Sequence[Segment], read: np.ndarray | None = None
) -> tuple[Remark, ...]:
    """All that is found on sight, each in one remark: what the reader of its file saw, what it
    cannot be, and what stands in it that its segments show; nothing for a plausible one.

    segments: its labels, or what was found; read: (k, 6) means of all their rows, where each is
    measured and they are known.
    """
    used = [s for s in segments if s.kind in ("static", "rate", "rotation")]
    return (
        *_seen_in_file(recording),
        *_impossible(recording, used, read),
        *held_remarks(recording, used),
        *(() if gives_angles(recording) else coarse_remarks(recording, used)),
    )


def _seen_in_file(recording: Recording) -> Iterator[Remark]:
    imported = (recording.manifest.model_extra or {}).get("imported")
    kept = imported.get(SEEN, ()) if isinstance(imported, dict) else ()
    with suppress(ValidationError):  # of a file that another wrote
        for one in SEEN_IN_FILE.validate_python(kept):
            yield found_on_sight(one.code, one.message, one.segments, one.run)


def _impossible(
    recording: Recording, used: Sequence[Segment], read: np.ndarray | None
) -> tuple[Remark, ...]:
    """What the recording cannot be."""
    scales = _units_of_source(recording)
    tracked = attitude_stream(recording) is not None and recording.table is None
    if len(recording.imu) < 2:
        return ()
    means = segment_means(recording, used, read)
    if (wrong := wrong_time(recording, used, means)) is not None:
        return (wrong,)
    if tracked:
        return _beside_poses(recording, scales)
    if not used:
        return ()
    gyro = matrix_by_segments(means.gyro, means.rate, EXCITED[0], forces=False)
    still = means.static & np.isfinite(means.up).all(axis=1)
    direction, removed = directions_of(means.accel), wrong_forces(recording, means, scales[1])
    is_removed = removed is not None and removed.code == "gravity_removed"
    accel = None if is_removed else matrix_of_directions(direction[still], means.up[still])
    between_rests = partial(ways, recording, used, means)
    usual = _is_usual(gyro)
    wrong = wrong_labels(used, means) if usual or gyro is None else None
    if wrong is None and not usual:
        wrong = wrong_table(recording, means, between_rests)
    if wrong is not None:
        return (wrong,)
    source = "labels" if recording.table is None else "table"
    rates = wrong_rates(recording, responses(gyro), sizes_by_rates(means), scales[0], source)
    if gyro is None and not (means.rate[~means.static] != 0.0).any():
        rates = wrong_rates_by_ways(recording, between_rests(), scales[0])
    shifted = _shift(recording, gyro) if recording.manifest.segments else None
    mapped = None
    if shifted is None:
        mapped = turned_aslant(gyro, accel) or wrong_axes(gyro, accel)
        mapped = mapped or columns_of_others(means, gyro)
    return tuple(one for one in (removed, rates, shifted, mapped) if one is not None)


def _beside_poses(recording: Recording, scales: tuple[float, float]) -> tuple[Remark, ...]:
    """The rates of a tracked body's unit, which may be turned against it in any way."""
    wrong = wrong_rates(recording, sizes_beside_poses(recording), np.zeros(0), scales[0], "pose")
    return () if wrong is None else (wrong,)


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
    common = common_factor(responses(gyro))
    return common is not None and GAINS[0] < common < GAINS[1]


def _shift(recording: Recording, gyro: TriadMatrix | None) -> Remark | None:
    common = common_factor(responses(gyro))
    found = shift_of_labels(recording, 1.0 if common is None or _is_usual(gyro) else common)
    if found is None:
        return None
    late = found.seconds < 0
    option = f"--shift {found.seconds:.2f}"
    return found_on_sight(
        "labels_shifted",
        message("plausibility-labels-shifted", seconds=f"{abs(found.seconds):.2f}",
                within=f"{found.within:.2f}", late="late" if late else "early", option=option),
    )  # fmt: skip
