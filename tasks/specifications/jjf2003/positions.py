"""The positions of 7.2.2.1: which axes were up, at which headings, and their averages U_i."""

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

import numpy as np

from schemas.calibration import Remark
from schemas.recording import AXES
from tasks.segments.summarise import SegmentMean
from tasks.specifications.evidence import UPS, Evidence


@dataclass(frozen=True)
class Triad:
    """Three sensors that are recorded together: their name, and which segments hold them."""

    en: str
    zh: str
    serves: Callable[[SegmentMean], bool]


TRIADS = (
    Triad("gyro", "陀螺", lambda segment: segment.has_gyro),
    Triad("accelerometer", "加速度计", lambda segment: segment.has_accel),
)


def input_matrix(ups: tuple[str, ...]) -> np.ndarray:
    """Transposed Ā of 7.2.2.2: a row (aₓ, a_y, a_z, 1) in local g for each position."""
    rows = np.zeros((len(ups), 4))
    for row, up in enumerate(ups):
        rows[row, AXES.index(up[1])] = 1.0 if up[0] == "+" else -1.0
        rows[row, 3] = 1.0
    return rows


def usable_positions(
    evidence: Evidence, serves: Callable[[SegmentMean], bool]
) -> dict[str, tuple[int, ...]]:
    """The positions with at least one usable rest, by axis up, in the order of the clause."""
    usable = {
        up: tuple(i for i in evidence.positions[up] if serves(evidence.segments[i])) for up in UPS
    }
    return {up: indices for up, indices in usable.items() if indices}


def averages(evidence: Evidence, positions: dict[str, tuple[int, ...]]) -> np.ndarray:
    """Operator (positions, segments) that gives U_i, the mean over headings (7.2.2.1 a).

    Every heading counts once. Where some are 180° apart, only those pairs count: a third
    heading would bring back what the pair cancels.
    """
    operator = np.zeros((len(positions), len(evidence.segments)))
    for row, indices in enumerate(positions.values()):
        headings = _headings(evidence, indices)
        counted = [h for h in headings if _opposite(h, headings)] or list(headings)
        for heading in counted:
            same = headings[heading]
            operator[row, same] = 1.0 / len(counted) / len(same)
    return operator


def _headings(evidence: Evidence, indices: tuple[int, ...]) -> dict[float | None, list[int]]:
    """The rests of a position by heading, degrees modulo 360 to the nearest one."""
    by_heading: dict[float | None, list[int]] = {}
    for i in indices:
        turn = evidence.segments[i].segment.turn_deg
        heading = None if turn is None else float(round(turn) % 360)
        by_heading.setdefault(heading, []).append(i)
    return by_heading


def _opposite(heading: float | None, headings: Collection[float | None]) -> bool:
    """Whether another heading lies 180° from this one, within 1°."""
    if heading is None:
        return False
    known = [other for other in headings if other is not None]
    return any(abs((heading - other) % 360 - 180) <= 1 for other in known)


def is_paired(evidence: Evidence, indices: tuple[int, ...]) -> bool:
    """Whether a position was held at two headings 180° apart, as 7.2.2.1 a) asks."""
    headings = _headings(evidence, indices)
    return any(_opposite(heading, headings) for heading in headings)


def position_remarks(evidence: Evidence) -> Iterator[Remark]:
    """Conditions of 7.2.2.1 a): six axes up, each at two headings, for each triad recorded."""
    absent: dict[tuple[str, ...], list[Triad]] = {}
    single: dict[tuple[str, ...], list[Triad]] = {}
    for triad in _recorded(evidence):
        positions = usable_positions(evidence, triad.serves)
        absent.setdefault(tuple(up for up in UPS if up not in positions), []).append(triad)
        alone = (up for up, rests in positions.items() if not is_paired(evidence, rests))
        single.setdefault(tuple(alone), []).append(triad)
    for ups, triads in absent.items():
        if ups:
            yield _missing(", ".join(ups), triads)
    for ups, triads in single.items():
        if ups:
            yield _one_heading(", ".join(ups), triads)


def _recorded(evidence: Evidence) -> tuple[Triad, ...]:
    """The triads that some segment has; both where there is none."""
    found = tuple(t for t in TRIADS if any(t.serves(segment) for segment in evidence.segments))
    return found or TRIADS


def _missing(listed: str, triads: list[Triad]) -> Remark:
    return Remark(
        code="positions_missing",
        en=f"No usable rest with {listed} up of the {' and '.join(t.en for t in triads)} triad; "
        "7.2.2.1 asks for all six.",
        zh=f"{'和'.join(t.zh for t in triads)}缺少 {listed} 朝天的可用静止位置；"
        "7.2.2.1 要求六个方向齐全。",
        blocks_pass=True,
    )


def _one_heading(listed: str, triads: list[Triad]) -> Remark:
    return Remark(
        code="one_heading",
        en=f"{listed} up: {' and '.join(t.en for t in triads)} not recorded at two headings 180° "
        "apart as 7.2.2.1 asks; the horizontal part of Earth's rotation and of the table's tilt "
        "does not cancel.",
        zh=f"{listed} 朝天：{'和'.join(t.zh for t in triads)}未按 7.2.2.1 在相差 180° 的两个方位"
        "测量，地球自转及转台倾斜的水平分量未抵消。",
        blocks_pass=True,
    )
