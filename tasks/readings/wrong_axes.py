"""Axes exchanged, inverted or turned as a whole, and columns of another sensor."""

import numpy as np

from schemas.recording import AXES, GYRO
from schemas.text import Remark
from tasks.readings.axes import MATRICES, TriadMatrix, fitting
from tasks.readings.implausible import found_on_sight
from tasks.readings.segment_means import SegmentMeans, matrix_by_segments
from tasks.words import Message, message

ASLANT = np.radians(10.0)  # from the nearest axes: a label that says an axis is up is wrong
ROTATION = 0.15  # by which the matrix of a unit that is turned may be none
SAME = np.radians(8.0)  # between the turns that both triads show
OF_FORCE = 0.2  # rad/s to either side, as gravity points: no gyro, which has 0.05 at the worst
FOLLOWS = 0.95  # of the variance of a column, which gravity explains
NOTHING = 0.2  # of what is read of the other inputs


def turned_aslant(gyro: TriadMatrix | None, accel: TriadMatrix | None) -> Remark | None:
    """A unit that is turned against the labels' axes by an angle that no exchange of axes is."""
    turns = [turn for one in (gyro, accel) if one is not None and (turn := _turn(one)) is not None]
    known = [one for one in (gyro, accel) if one is not None]
    if not turns or len(turns) < len(known):
        return None
    turn = turns[0]
    if len(turns) == 2 and _angle(turns[0].T @ turns[1]) > SAME:
        return None
    proper = [matrix for matrix in MATRICES if np.linalg.det(matrix) > 0]
    if min(_angle(matrix.T @ turn) for matrix in proper) < ASLANT:
        return None
    about = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    about = about / max(float(np.linalg.norm(about)), 1e-9)
    axis = ", ".join(f"{one:+.2f}" for one in about).replace("-", "−")
    degrees = f"{np.degrees(_angle(turn)):.1f}"
    return found_on_sight("mount", message("plausibility-mount", degrees=degrees, axis=axis))


def _turn(found: TriadMatrix) -> np.ndarray | None:
    """The rotation (3, 3) by which a triad reads its inputs; None where it is none, or where fewer
    than two inputs tell it.
    """
    if found.directions.shape[1] < 2:
        return None
    left, sizes, right = np.linalg.svd(found.reads @ found.directions.T)
    known = sizes[: found.directions.shape[1]]
    if np.abs(np.log(np.maximum(known, 1e-9) / known.mean())).max() > ROTATION:
        return None
    if found.directions.shape[1] == 2:
        right[2] *= np.linalg.det(left) * np.linalg.det(right)
    turn = np.asarray(left @ right)
    return turn if np.linalg.det(turn) > 0 else None


def _angle(turn: np.ndarray) -> float:
    return float(np.arccos(np.clip(0.5 * (np.trace(turn) - 1.0), -1.0, 1.0)))


def columns_of_others(means: SegmentMeans, gyro: TriadMatrix | None) -> Remark | None:
    """Columns that are not what they are called: a gyro's that follows gravity, or a triad that
    reads nothing of one of its inputs.
    """
    rests = means.static & np.isfinite(means.up).all(axis=1)
    force = matrix_by_segments(means.accel[rests], means.up[rests], 0.1, forces=False)
    wrong = [message("plausibility-column-follows", channel=GYRO[c]) for c in _forces(means, rests)]
    for triad, found in (("gyro", gyro), ("accel", force)):
        if found is None or found.directions.shape[1] < len(AXES):
            continue
        sizes = np.linalg.norm(found.reads @ found.directions.T, axis=0)
        wrong += [
            message("plausibility-column-nothing", triad=triad, axis=AXES[k])
            for k in np.flatnonzero(sizes < NOTHING * np.median(sizes))
        ]
    if not wrong:
        return None
    return found_on_sight("column_exchanged", message("plausibility-columns", what=tuple(wrong)))


def _forces(means: SegmentMeans, rests: np.ndarray) -> list[int]:
    """The gyros that follow gravity at rest."""
    gyro, up = means.gyro[rests], means.up[rests]
    columns = np.column_stack([np.ones(len(up)), up])
    if len(up) <= columns.shape[1] or not np.isfinite(gyro).all():
        return []
    found = np.linalg.lstsq(columns, gyro, rcond=None)[0]
    left, whole = (gyro - columns @ found).var(axis=0), gyro.var(axis=0)
    size = np.linalg.norm(found[1:], axis=0)
    return np.flatnonzero((size > OF_FORCE) & (left < (1.0 - FOLLOWS) * whole)).tolist()


def wrong_axes(gyro: TriadMatrix | None, accel: TriadMatrix | None) -> Remark | None:
    """Axes exchanged or inverted in one triad, or alike in both."""
    choices = [None if one is None else fitting(one) for one in (gyro, accel)]
    wrong = [k for k, good in enumerate(choices) if good and not _is_identity(good[0])]
    if not wrong:
        return None
    known = [k for k, good in enumerate(choices) if good]
    chosen = {k: choices[k][0] for k in wrong}  # type: ignore[index]
    both = len(known) == 2 and len(wrong) == 2
    if both:
        alike = [m for m in choices[0] or () if any(np.array_equal(m, n) for n in choices[1] or ())]
        both = bool(alike)
        chosen = dict.fromkeys(wrong, alike[0]) if both else chosen
    # Of a turn that one triad shows and the other says nothing of, the unit as it lay is the cause.
    both = both or (len(known) == 1 and np.linalg.det(chosen[wrong[0]]) > 0.0)
    entries, reads = list[str](), list[Message]()
    for k in wrong[:1] if both else wrong:
        name = "" if both else ("gyro_", "accel_")[k]
        matrix = chosen[k]
        entries += _entries(matrix.T, name)
        reads.append(_reads(matrix, "both" if both else ("gyro", "accel")[k]))
    option = f"--axes {','.join(entries)}"
    value = _response((gyro, accel)[wrong[0]], chosen[wrong[0]])
    return found_on_sight(
        "axes", message("plausibility-axes", reads=tuple(reads), value=value, option=option)
    )


def _is_identity(matrix: np.ndarray) -> bool:
    return bool(np.array_equal(matrix, np.eye(3)))


def _entries(matrix: np.ndarray, name: str) -> list[str]:
    """NEW=OLD of a signed permutation that puts readings in their places."""
    made = []
    for row, axis in enumerate(AXES):
        source = int(np.abs(matrix[row]).argmax())
        if matrix[row, row] != 1.0:
            sign = "-" if matrix[row, source] < 0 else ""
            made.append(f"{name}{axis}={sign}{name}{AXES[source]}")
    return made


def _reads(matrix: np.ndarray, triad: str) -> Message:
    """What a triad does: axes inverted, two exchanged, turned as a whole, or a mirror image."""
    moved = [k for k in range(3) if matrix[k, k] == 0.0]
    inverted = [k for k in range(3) if matrix[k, k] == -1.0]
    listed = ", ".join(
        f"{AXES[k]}: {'−' if matrix[k].sum() < 0 else '+'}{AXES[int(np.abs(matrix[k]).argmax())]}"
        for k in range(3) if matrix[k, k] != 1.0
    )  # fmt: skip
    if not moved and len(inverted) != 2:
        kind, names = "inverted", [AXES[k] for k in inverted]
    elif len(moved) == 2 and not inverted and matrix[moved].sum() == 2.0:
        kind, names = "exchanged", [AXES[k] for k in moved]
    else:
        kind = "turned" if np.linalg.det(matrix) > 0 else "mirrored"
        names = []
    return message(
        f"plausibility-{kind}", triad=triad, axes=", ".join(names) or "-",
        map=listed,
    )  # fmt: skip


def _response(found: TriadMatrix | None, matrix: np.ndarray) -> str:
    """What is read of the first input that is not read along its axis, as `zz = −1.003`."""
    assert found is not None
    full = found.reads @ found.directions.T
    wrong = [(r, int(np.abs(matrix[r]).argmax())) for r in range(3) if matrix[r, r] != 1.0]
    row, column = max(wrong, key=lambda place: abs(full[place]))
    return f"{AXES[row]}{AXES[column]} = {full[row, column]:.3f}".replace("-", "−")
