"""What turns and rests leave of the horizontal part of Earth's rotation in the mean readings.

A gyro across the axis that turns about the vertical feels it come and go. Over whole turns nothing
is left; over a part of a turn, or where the table rests before and after within a segment, the
clauses take the reading as it is. By how much the unit turned meanwhile it says itself; where
north was when it began is not known.
"""

import math
from collections.abc import Iterator
from functools import cache

import numpy as np

from schemas.recording import AXES, Segment
from tasks.motion.table import EARTH_RATE
from tasks.motion.whole import Motion
from tasks.segments.attitude import VERTICAL, attitude_vector
from tasks.segments.summarise import CHANNELS
from tasks.specifications.error_sources import ErrorSource
from tasks.specifications.evidence import ClauseEvidence
from tasks.uncertainty.budget import InputQuantity
from tasks.words import message


def horizontal_earth(evidence: ClauseEvidence) -> Iterator[ErrorSource]:
    """Its source, with a draw for the north and one for the east where each turn began.

    Turns by whole turns about one axis come back to where they began; a held rate begins anywhere.
    """
    turning = [i for i, label in enumerate(evidence.labels) if label.kind != "static"]
    begun = [_beginning(evidence.labels[i]) for i in turning]
    places = {place: 2 * k for k, place in enumerate(dict.fromkeys(begun))}
    effects = np.zeros((2 * len(places), len(evidence.segments), len(CHANNELS)))
    for i, place in zip(turning, begun, strict=True):
        axis = AXES.index(evidence.labels[i].axis or "x")
        left, north = evidence.mean_turns[i], places[place]
        across = [(axis + 1) % 3, (axis + 2) % 3]
        effects[north, i, across] = left.real, -left.imag
        effects[north + 1, i, across] = left.imag, left.real
    effects = np.concatenate([effects, _of_rests(evidence)])
    if effects.any():
        yield ErrorSource(_quantity(evidence.latitude_deg), "point", effects)


def _of_rests(evidence: ClauseEvidence) -> np.ndarray:
    """Effects (m, n, 6) on rests of unknown heading: two draws for each face, which turn with the
    rests on it, so that two headings 180° apart are free of it; a rest without heading has its own.
    """
    blind = [
        i
        for i in evidence.of_kind("static")
        if evidence.up[i] is not None
        and not np.isfinite(evidence.north[i]).all()
        and not _pointed(attitude_vector(evidence.recording, evidence.labels[i]))
    ]
    labels = evidence.labels
    places = [
        str(evidence.up[i] if labels[i].turn_deg is not None else labels[i].name) for i in blind
    ]
    faces = list(dict.fromkeys(places))
    effects = np.zeros((2 * len(faces), len(evidence.segments), len(CHANNELS)))
    for i, place in zip(blind, places, strict=True):
        up, turn = str(evidence.up[i]), math.radians(labels[i].turn_deg or 0.0)
        axis, way = AXES.index(up[1]), 1.0 if up[0] == "+" else -1.0
        across, k = [(axis + 1) % 3, (axis + 2) % 3], 2 * faces.index(place)
        effects[k, i, across] = math.cos(turn), -way * math.sin(turn)
        effects[k + 1, i, across] = way * math.sin(turn), math.cos(turn)
    return effects


def level_covariance(evidence: ClauseEvidence, motion: Motion, gyro: int) -> np.ndarray:
    """Covariance (n, n), (rad/s)², of one gyro's rests by a horizontal rate of unknown direction.

    motion: mean of each segment. A gyro that lies level reads ωe·cos φ·cos(ψ + heading) with ψ
    unknown: half the square of the amplitude, times the cosine of the turn between two headings of
    one face. The mean of two headings 180° apart is free of it, and its scatter is not the unit's.
    Without a latitude the whole of ωe is taken; without a heading a rest shares nothing with
    another.
    """
    still = np.array([label.kind == "static" for label in evidence.labels], bool)
    blind = still & ~np.isfinite(motion.north).all(axis=1)
    level = blind * np.sqrt(np.clip(1.0 - np.nan_to_num(motion.up[:, gyro]) ** 2, 0.0, 1.0))
    heading = np.radians(np.array([label.turn_deg for label in evidence.labels], float))
    same = [[a == b for b in evidence.up] for a in evidence.up]
    shared = np.nan_to_num(np.cos(heading[:, None] - heading)) * np.reshape(same, 2 * still.shape)
    np.fill_diagonal(shared, 1.0)
    return np.asarray(_quantity(evidence.latitude_deg).u ** 2 * np.outer(level, level) * shared)


def _pointed(attitude: np.ndarray | None) -> bool:
    """Whether an attitude vector says how the unit lies to the station, whose heading is one."""
    return attitude is not None and bool(attitude[:, :VERTICAL].any())


def _beginning(label: Segment) -> str:
    """What tells apart where segments that turn begin."""
    return f"{label.axis} {label.up}" if label.kind == "rotation" else label.name


@cache
def _quantity(latitude_deg: float | None) -> InputQuantity:
    """Earth's rotation along a horizontal direction that may be any."""
    largest = EARTH_RATE * math.cos(math.radians(latitude_deg or 0.0))
    return InputQuantity(
        "ωN", message("uncertainty-horizontal-earth"), "rad/s", largest / math.sqrt(2.0), "B",
        "arcsine", half_width=largest, source="WGS 84",
    )  # fmt: skip
