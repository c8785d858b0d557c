"""The reference of a recording as the certificates of the standards have it.

An error of indication that a certificate states, and that is corrected, is taken off what the
recording says of its motion before any method sees it: off held rates, whether encoders or labels
state them; off the angles of the encoders; off local gravity; off the times of all streams.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from schemas.base import Unusable
from schemas.laboratory import ErrorFunction, LimitName, MeasurementStandard
from schemas.recording import MEASURED, Recording, Segment, Stream
from tasks.motion.table import table_angles
from tasks.uncertainty.equipment import EDGE, error_at, extent, source_of

NANOSECONDS = 9  # places of the times of a recording
SERVO_DEG = 0.1  # an angle so little beyond the last one of a certificate is that one
UNITS: Mapping[LimitName, str] = {"rate": "°/s", "position": "°"}


def as_certified(
    recording: Recording, standards: Iterable[MeasurementStandard], own: Collection[LimitName] = ()
) -> Recording:
    """The recording with every corrected error of its standards taken off its reference.

    own: properties of which the laboratory states a limit itself, which goes before the standards.
    Raises Unusable where a rate or an angle of the run is beyond what a certificate states, whether
    it is corrected or budgeted, and where the recording does not show what to correct.
    """
    faults: list[str] = []
    seen: dict[LimitName, str] = {}
    for standard in standards:
        for name, function in standard.functions.items():
            if name in own:
                continue
            paper = source_of(standard)
            if name in seen:
                raise Unusable(
                    f"{seen[name]} and {paper} both state the error of {name} as a function, and a "
                    "run has one of them: leave one out of the equipment"
                )
            seen[name] = paper
            try:
                recording = CORRECTIONS[name](recording, function)
            except ValueError as fault:
                faults.append(f"{paper} states the error of {name}, and {fault}")
    if faults:
        raise Unusable(f"{recording.manifest.recording_id}: {'; '.join(faults)}")
    return recording


def _rates(recording: Recording, function: ErrorFunction) -> Recording:
    """Each held rate with its error, by its label's rate about the axis that turned."""
    if recording.manifest.segments is None:
        raise ValueError("the recording has no labelled segments that say its rates: label them")
    held = [s for s in recording.manifest.segments if s.kind == "rate" and s.rate_deg_s]
    axes = {segment.name: _turning(recording, segment, function) for segment in held}
    rates = [(s.name, axes[s.name], abs(s.rate_deg_s or 0.0)) for s in held]
    _check("rate", function, ((*each, each[-1] * (1.0 - EDGE)) for each in rates))
    if function.deviation == "budgeted":
        return recording
    errors = {name: float(error_at(function, axis, rate)) for name, axis, rate in rates}
    return replace(recording, rate_errors=errors)


def _turning(recording: Recording, segment: Segment, function: ErrorFunction) -> str | None:
    """The table's axis that turned in a segment; None where the certificate names none."""
    if function.axes == (None,):
        return None
    named = [axis.name for axis in recording.manifest.station.table_axes or ()]
    if len(named) == 1:
        return named[0]
    if segment.table_axis is not None and segment.table_axis < len(named):
        return named[segment.table_axis]
    angles = table_angles(recording, segment)
    if len(angles) < 2:
        raise ValueError(
            f"the recording does not show which axis turned in segment {segment.name}: record the "
            "encoders, label table_axis, or state one error for every axis"
        )
    return named[int(np.abs(angles[-1] - angles[0]).argmax())]


def _angles(recording: Recording, function: ErrorFunction) -> Recording:
    """The encoders with the error of each axis at each angle."""
    table, axes = recording.table, recording.manifest.station.table_axes or ()
    if table is None or not axes:
        if function.deviation == "budgeted":
            return recording
        raise ValueError(
            "the recording has no encoders that it could be taken off: record them, or state "
            'deviation = "budgeted"'
        )
    _check("position", function, _held_angles(recording, function))
    if function.deviation == "budgeted":
        return recording
    columns = dict(table.columns)
    for axis in axes:
        column = f"{axis.name}_angle"
        at = _within(np.degrees(columns[column]), extent(function, axis.name))
        columns[column] = columns[column] - error_at(function, axis.name, at)
    return replace(recording, table=replace(table, columns=columns))


def _held_angles(
    recording: Recording, function: ErrorFunction
) -> Iterator[tuple[str, str, float, float]]:
    """Where each axis stood in a rest, and where a turn began and ended.

    A held rate passes every angle, and over whole turns nothing is left of their errors.
    """
    axes = recording.manifest.station.table_axes or ()
    for segment in recording.manifest.segments or ():
        angles = np.degrees(table_angles(recording, segment))
        if segment.kind == "rate" or segment.kind not in MEASURED or not len(angles):
            continue
        ends = angles.mean(axis=0)[None] if segment.kind == "static" else angles[[0, -1]]
        for k, axis in enumerate(axes):
            for angle in _within(ends[:, k], extent(function, axis.name)).tolist():
                yield segment.name, axis.name, angle, SERVO_DEG


def _within(degrees: np.ndarray, stated: tuple[float, float] | None) -> np.ndarray:
    """Angles turned whole turns to where a certificate states them, or beyond its end."""
    lowest = stated[0] if stated else 0.0
    return np.asarray(lowest - SERVO_DEG + (degrees - lowest + SERVO_DEG) % 360.0)


def _check(
    name: LimitName,
    function: ErrorFunction,
    used: Iterable[tuple[str, str | None, float, float]],
) -> None:
    """used: segment, axis, rate or angle, and how far beyond the end it may be."""
    beyond: dict[str, str] = {}
    for segment, axis, x, allowed in used:
        stated, about = extent(function, axis), f" about axis {axis}" if axis else ""
        if stated is None:
            beyond.setdefault(about, f"not{about}, as segment {segment} needs")
        elif not stated[0] - allowed <= x <= stated[1] + allowed:
            low, high = (f"{edge:g}" for edge in stated)
            beyond.setdefault(
                about,
                f"only from {low} to {high} {UNITS[name]}{about}, while segment {segment} was held "
                f"at {x:g} {UNITS[name]}",
            )
    if beyond:
        raise ValueError(
            f"{' and '.join(beyond.values())}: add what the certificate says there, or "
            f"state a limit of {name}"
        )


def _gravity(recording: Recording, function: ErrorFunction) -> Recording:
    manifest, stated = recording.manifest, recording.manifest.station.gravity_m_s2
    if stated is None or function.deviation == "budgeted":
        return recording
    actual = manifest.station.model_copy(
        update={"gravity_m_s2": stated - float(error_at(function, None))}
    )
    return replace(recording, manifest=manifest.model_copy(update={"station": actual}))


def _times(recording: Recording, function: ErrorFunction) -> Recording:
    """A clock that counts too many seconds by a relative error, in every stream and label."""
    if function.deviation == "budgeted":
        return recording
    factor = 1.0 / (1.0 + float(error_at(function, None)))

    def actual(stream: Stream) -> Stream:
        t = np.round(stream.t * factor, NANOSECONDS)
        return replace(stream, t=t, span=stream.span * factor)

    manifest = recording.manifest
    segments = manifest.segments and tuple(
        s.model_copy(update={"t_start": s.t_start * factor, "t_end": s.t_end * factor})
        for s in manifest.segments
    )
    streams: dict[str, Any] = {n: actual(stream) for n, stream in recording.streams().items()}
    manifest = manifest.model_copy(update={"segments": segments})
    return replace(recording, manifest=manifest, **streams)


CORRECTIONS = {"rate": _rates, "position": _angles, "gravity": _gravity, "time_base": _times}
