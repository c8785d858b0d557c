"""Axes exchanged, inverted or turned as a whole."""

import numpy as np

from schemas.recording import AXES
from tasks.readings.axes import TriadMatrix, fitting
from tasks.readings.implausible import Implausible
from tasks.words import Message, message


def wrong_axes(gyro: TriadMatrix | None, accel: TriadMatrix | None) -> Implausible | None:
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
    return Implausible(
        "axes", message("plausibility-axes", reads=tuple(reads), value=value, option=option), option
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
