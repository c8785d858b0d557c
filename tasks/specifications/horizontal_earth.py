"""What turns leave of the horizontal part of Earth's rotation in the mean readings.

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
        left, north = evidence.course[i], places[place]
        across = [(axis + 1) % 3, (axis + 2) % 3]
        effects[north, i, across] = left.real, -left.imag
        effects[north + 1, i, across] = left.imag, left.real
    if effects.any():
        yield ErrorSource(_quantity(evidence.latitude_deg), "point", effects)


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
