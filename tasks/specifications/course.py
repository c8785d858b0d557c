"""The course of each zero over a run: a drift that its rests show beside noise and equipment."""

from collections.abc import Iterator
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.polynomial import legendre

from schemas.recording import AXES
from schemas.text import Remark
from tasks.motion.whole import Motion
from tasks.segments.summarise import CHANNELS
from tasks.specifications.error_sources import EquipmentErrors
from tasks.specifications.estimate import DEG
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.horizontal_earth import level_covariance
from tasks.specifications.linear import last_shown
from tasks.words import message, remark

Evidence = TypeVar("Evidence", bound=ClauseEvidence)
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
    up = motion.up
    rests = [i for i in evidence.of_kind("static") if np.isfinite(up[i]).all()]
    course = np.zeros((len(CHANNELS), len(t)))
    if not rests:
        return evidence
    first = min(s.t_start for s in evidence.segments)
    last = max(s.t_end for s in evidence.segments)
    shapes = legendre.legvander(2.0 * (t - first) / (last - first) - 1.0, COURSE)[:, 1:]
    north = evidence.north[rests]
    level = [north, np.cross(north, up[rests])] if np.isfinite(north).all() else []
    for c in range(channels):
        faces = [np.ones(len(rests)), *up[rests].T]
        faces += [each[:, c] for each in level if c < len(AXES)]
        design = np.column_stack([*faces, shapes[rests]])
        known = evidence.fast_covariance(c) + errors.covariance(c)
        if c < len(AXES) and not level:
            known = known + level_covariance(evidence, motion, c)
        readings = evidence.means[rests, c]
        found, chance = last_shown(design, readings, known[np.ix_(rests, rests)], COURSE)
        if chance < COURSE_LEVEL:
            course[c] = shapes @ found[-COURSE:]
    return replace(evidence, course=course) if course.any() else evidence


def course_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """That zeros drifted in the run, and by how much from end to end."""
    sizes = np.zeros(len(CHANNELS)) if evidence.course is None else np.ptp(evidence.course, axis=1)
    for first, unit, per in ((0, "deg/s", DEG), (len(AXES), "m/s2", 1.0)):
        drifted = [c for c in range(first, first + len(AXES)) if sizes[c]]
        if drifted:
            channels = ", ".join(f"{CHANNELS[c]} {per * sizes[c]:.2g}" for c in drifted)
            phrase = message("specifications-drift-in-run", channels=channels, unit=unit)
            yield remark("drift_in_run", phrase)
