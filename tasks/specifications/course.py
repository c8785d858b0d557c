"""The course of each zero over a run: a drift that its rests show beside noise and equipment."""

from collections.abc import Iterator
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.polynomial import legendre

from schemas.recording import AXES
from schemas.text import Remark
from tasks.motion.whole import Motion, attitude_stream
from tasks.segments.summarise import CHANNELS
from tasks.specifications.equipment_errors import EquipmentErrors, level_covariance
from tasks.specifications.estimate import DEG
from tasks.specifications.evidence import ClauseEvidence, last_shown
from tasks.words import message, remark

Evidence = TypeVar("Evidence", bound=ClauseEvidence)
FOLLOWS = 1e-4  # that gain and zero of a channel follow the temperature as much by chance
RIPPLE = 5e-4  # of a rate within a turn, Table 1 of JJF 2003-2022
COURSE, COURSE_LEVEL = 3, 1e-3  # degree of a zero's course in time, and how often noise makes one


def with_course(
    evidence: Evidence,
    motion: Motion,
    errors: EquipmentErrors,
    channels: int = len(CHANNELS),
) -> Evidence:
    """The evidence with the course of each zero over the run, where its rests show one.

    Judged against white noise, flicker, rounding and the equipment, before anything is enlarged by
    what the points scatter. motion: mean of each segment; where north is not known, the level part
    of Earth's rotation is no course.
    channels: how many of the first, those that are calibrated.
    """
    t = np.array([0.5 * (s.t_start + s.t_end) for s in evidence.segments])
    held = [i for i in evidence.of_kind("static") if np.isfinite(motion.up[i]).all()]
    course = np.zeros((len(CHANNELS), len(t)))
    if not held:
        return evidence
    first = min(s.t_start for s in evidence.segments)
    last = max(s.t_end for s in evidence.segments)
    per_kelvin = np.zeros_like(course)
    for c in range(channels):
        values = following(evidence, c)
        if values is not None:
            felt = motion.rate[:, c] if c < len(AXES) else motion.up[:, c - len(AXES)]
            per_kelvin[c] = values[2] * np.nan_to_num(felt)
    if per_kelvin.any():
        evidence = replace(evidence, per_kelvin=per_kelvin)
    shapes = legendre.legvander(2.0 * (t - first) / (last - first) - 1.0, COURSE)[:, 1:]
    pointed = bool(np.isfinite(evidence.north[held]).all())
    for c in range(channels):
        rests = comparable(evidence, held, c)
        up, north = motion.up[rests], evidence.north[rests]
        level = [north, np.cross(north, up)] if pointed and c < len(AXES) else []
        columns = [np.ones(len(rests)), *up.T, *(each[:, c] for each in level)]
        known = evidence.fast_covariance(c) + errors.covariance(c)
        if c < len(AXES) and not level:
            known = known + level_covariance(evidence, motion, c)
        found, chance = last_shown(
            np.column_stack([*columns, shapes[rests]]), evidence.means[rests, c],
            known[np.ix_(rests, rests)], COURSE,
        )  # fmt: skip
        if chance < COURSE_LEVEL:
            course[c] = shapes @ found[-COURSE:]
    return replace(evidence, course=course) if course.any() else evidence


def following(evidence: ClauseEvidence, channel: int) -> np.ndarray | None:
    """A channel's gain, its zero, and the change of both per K (4,), where its readings follow the
    recorded temperature of the unit.

    Of the segments with a known input: the rate about a gyro's own axis, gravity along that of an
    accelerometer.
    """
    at, axis = evidence.temperatures, AXES[channel % len(AXES)]
    if channel < len(AXES):
        used = list(evidence.points[axis])
        given = evidence.rate[used]
        turned = np.abs(given) * [evidence.segments[i].seconds for i in used]
        reference = (RIPPLE * given / np.maximum(turned, 1.0)) ** 2 / 3.0
    else:
        used = [i for i in evidence.of_kind("static") if (evidence.up[i] or "")[1:] == axis]
        given = np.array([1.0 if (evidence.up[i] or "")[0] == "+" else -1.0 for i in used])
        reference = np.zeros(len(used))
    if not used or not np.isfinite(at).all() or np.ptp(at) == 0.0:
        return None
    warm = at[used] - at[used].mean()
    design = np.column_stack([given, np.ones(len(used)), given * warm, warm])
    spread = evidence.fast_covariance(channel)[np.ix_(used, used)] + np.diag(reference)
    values, chance = last_shown(design, evidence.means[used, channel], spread, 2)
    return values if chance < FOLLOWS else None


def comparable(evidence: ClauseEvidence, rests: list[int], channel: int) -> list[int]:
    """The rests that repeat one another in a channel.

    Where no encoder says how the unit lay, a level accelerometer reads how it was laid by hand: a
    tilt of half a degree is 0.09 m/s² there, and 0.0004 m/s² on the axis that is vertical.
    """
    if channel < len(AXES) or attitude_stream(evidence.recording) is not None:
        return rests
    axis = AXES[channel - len(AXES)]
    return [i for i in rests if (evidence.up[i] or "")[1:] == axis]


def course_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """That zeros drifted in the run, and by how much from end to end."""
    sizes = np.zeros(len(CHANNELS)) if evidence.course is None else np.ptp(evidence.course, axis=1)
    for first, unit, per in ((0, "deg/s", DEG), (len(AXES), "m/s2", 1.0)):
        drifted = [c for c in range(first, first + len(AXES)) if sizes[c]]
        if drifted:
            channels = ", ".join(f"{CHANNELS[c]} {per * sizes[c]:.2g}" for c in drifted)
            phrase = message("specifications-drift-in-run", channels=channels, unit=unit)
            yield remark("drift_in_run", phrase)
