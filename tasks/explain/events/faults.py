"""Faults of logger and firmware that last from the first row to the last.

Wrong settings and wrong codes: both are undone before anything else is looked for.
"""

import numpy as np

from tasks.explain.channels import TRIADS
from tasks.explain.events.code_fault import CodeFault, find_code_fault
from tasks.explain.events.settings import (
    AxisMapping,
    RangeSetting,
    TriadMatrix,
    axis_mapping,
    find_range_setting,
    fitting,
    triad_matrix,
)
from tasks.motion.whole import Motion

Setting = RangeSetting | AxisMapping
Fault = Setting | CodeFault


def find_faults(readings: np.ndarray, motion: Motion, tracked: bool | None) -> tuple[Fault, ...]:
    """Wrong settings and codes of readings (n, 6) rad/s, m/s², in the order in which they act.

    tracked: whether the motion is that of a tracked body; None: settings are not looked for.
    """
    codes = find_code_fault(readings, motion)
    if codes is not None:
        readings = codes.undone(readings)
    settings = () if tracked is None else find_settings(readings, motion, tracked)
    return settings if codes is None else (*settings, codes)


def find_settings(readings: np.ndarray, motion: Motion, tracked: bool) -> tuple[Setting, ...]:
    """Wrong settings of readings (n, 6) rad/s, m/s², in the order in which they act.

    tracked: the motion is that of a tracked body, which may be turned against the unit in any way,
    so that what turns both triads alike is the reference's.
    """
    matrices = [triad_matrix(readings, motion, triad) for triad in range(len(TRIADS))]
    known = {triad: found for triad, found in enumerate(matrices) if found is not None}
    ranges = [find_range_setting(found, triad) for triad, found in known.items()]
    return (*_mappings(known, tracked), *(found for found in ranges if found is not None))


def _mappings(matrices: dict[int, TriadMatrix], tracked: bool) -> list[AxisMapping]:
    choices = {triad: fitting(found) for triad, found in matrices.items()}
    wrong = [t for t, good in choices.items() if good and not np.array_equal(good[0], np.eye(3))]
    if not wrong:
        return []
    common = [
        matrix
        for matrix in choices[wrong[0]]
        if np.linalg.det(matrix) > 0
        and all(any(np.array_equal(matrix, one) for one in good) for good in choices.values())
    ]
    # What a turned mount, or tracked body, would do to all that is known.
    if common and len(wrong) == len(matrices):
        return [] if tracked else [axis_mapping(triad, common[0], True) for triad in wrong]
    return [axis_mapping(triad, choices[triad][0], False) for triad in wrong]
