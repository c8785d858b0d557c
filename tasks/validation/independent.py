"""Other programs on the same data: plain least squares for values, GTC for the budgets."""

from importlib import import_module
from typing import Any

import numpy as np

from schemas.base import Unusable
from schemas.calibration import Item
from schemas.recording import ANGLE, AXES, Recording, Segment
from schemas.uncertainty import Budget
from schemas.validation import Check
from tasks.validation.coverage import Calibrate, simulate
from tasks.validation.plain_joint import DEGREE, Values, plain_joint, segment_means
from tasks.validation.record import checked
from tasks.validation.run2003 import matrix, printed_items, vector
from tasks.words import message

MAX_DIFFERENCE = 1e-3  # of u: the clauses' values are the same formulas
MAX_DIFFERENCE_JOINT = 0.01  # of u: the joint fit takes the attitude at other times of a segment
MAX_BUDGET_DIFFERENCE = 1e-6  # relative, of combined uncertainty and degrees of freedom


def independent_checks(method: str, calibrate: Calibrate, seed: int) -> dict[str, Check]:
    """Values against least squares on plain means, budgets against GTC, for each item."""
    recording, _ = simulate(method, seed)
    calibration = calibrate(recording, run="simulated", code_version="-")
    plain = PLAIN[method](recording)
    limit = MAX_DIFFERENCE_JOINT if method == "joint" else MAX_DIFFERENCE
    gtc = _gtc()
    return {
        name: _check(item, plain[name], limit, gtc)
        for name, item in calibration.items.items()
        if name in plain
    }


def _check(item: Item, plain: dict[str, float], limit: float, gtc: Any) -> Check:
    differences = [
        abs(value - plain[e]) / float(item.u[e] or np.nan)
        for e, value in item.value.items()
        if value is not None
    ]
    worst = max(differences, default=np.inf)
    budgets = max((gtc_difference(b, gtc) for b in item.budgets.values()), default=np.inf)
    return checked(
        worst <= limit and budgets <= MAX_BUDGET_DIFFERENCE,
        message(
            "validation-independent", values=f"{worst:.1e}", limit=f"{limit:g}",
            budgets=f"{budgets:.1e}", close=f"{MAX_BUDGET_DIFFERENCE:.0e}",
        ),
    )  # fmt: skip


def _gtc() -> Any:
    try:
        return import_module("GTC")
    except ImportError as absent:
        raise Unusable(
            "the package GTC is not installed, which budgets are compared with: install mimucal "
            "with its extra `dev` (make setup)"
        ) from absent


def gtc_difference(budget: Budget, gtc: Any) -> float:
    """Relative difference of a budget from GTC's: of u_c, and of the degrees of freedom."""
    total = gtc.ureal(budget.value, 0.0)
    for line in budget.inputs:
        total = total + line.sensitivity * gtc.ureal(0.0, line.u, line.dof)
    u = abs(total.u - budget.u_c) / budget.u_c if budget.u_c else abs(total.u)
    if np.isinf(budget.dof) or np.isinf(total.df):
        return u if budget.dof == total.df else np.inf
    return max(u, abs(total.df - budget.dof) / budget.dof)


def plain_2003(recording: Recording) -> Values:
    """Every item of JJF 2003 by numpy.linalg.lstsq on plain means, in printed units."""
    means = list(zip(recording.manifest.segments or (), segment_means(recording)[0], strict=True))
    gravity = float(recording.manifest.station.gravity_m_s2 or np.nan)
    K_gyro, offset, p = np.empty((3, 3)), np.empty(3), np.zeros((3, 3))
    for j, axis in enumerate(AXES):
        points = [(s, m) for s, m in means if s.kind == "rate" and s.axis == axis]
        rate = np.array([s.rate_deg_s or 0.0 for s, _ in points]) * DEGREE
        read = np.array([m for _, m in points])
        (K_gyro[:, j], line), *_ = np.linalg.lstsq(
            np.column_stack([rate, np.ones(len(rate))]), read[:, :3], rcond=None
        )
        offset[j] = line[j]
        rests = [m for s, m in means if s.item == "rate_sensitivity" and s.up == f"+{axis}"]
        fast = np.abs(rate) == np.abs(rate).max()
        turning = read[fast, 3:].mean(axis=0)
        p[:, j] = (np.mean(rests, axis=0)[3:] - turning) / rate[fast][0] ** 2
    held = [(s.up, m) for s, m in means if s.item == "twelve_position" and s.up]
    design = [[*(float(f"{up[0]}1") * (up[1] == a) for a in AXES), 1.0] for up, _ in held]
    both, *_ = np.linalg.lstsq(np.array(design), np.array([m for _, m in held]), rcond=None)
    tilted, bias = both[:3].T, both[3]
    return printed_items(K_gyro, offset, bias[:3], tilted[:3], tilted[3:] / gravity, bias[3:], p)


def plain_1536(recording: Recording) -> Values:
    """Every item of JJF 1536 from the angles at both ends of each segment, in printed units."""
    gains = [(s, *_gained(recording, s)) for s in recording.manifest.segments or ()]
    K, B, L = np.empty(3), np.empty(3), np.zeros((3, 3))
    for j, axis in enumerate(AXES):
        about = [(s, n, t) for s, n, t in gains if s.axis == axis]
        rest = np.mean([n[j] / t for s, n, t in about
                        if s.kind == "static" and s.item == "scale_factor"])  # fmt: skip
        points = [(s.rate_deg_s or 0.0, n[j] / t - rest) for s, n, t in about if s.kind == "rate"]
        rate, read = np.array(points).T
        K[j] = np.polyfit(rate * DEGREE, read, 1)[0]
        B[j] = np.mean([n[j] / t for s, n, t in about if s.item == "four_position"])
        turns = {s.angle_deg or 0.0: n for s, n, _ in about if s.kind == "rotation"}
        forward, back = max(turns), min(turns)
        L[:, j] = (turns[forward] - turns[back]) / (forward - back)
    return {
        "ahrs_scale_factor": vector(K),
        "ahrs_zero_offset": vector(B / DEGREE),
        "ahrs_misalignment": matrix(L / DEGREE**2, off_diagonal=True),
    }


def _gained(recording: Recording, segment: Segment) -> tuple[np.ndarray, float]:
    """Angles (3,) rad gained over a segment, and its time in s."""
    t = recording.imu.t
    ends = np.searchsorted(t, (segment.t_start - 1e-9, segment.t_end - 1e-9))
    angles = np.array([recording.imu.columns[name][ends] for name in ANGLE])
    return angles[:, 1] - angles[:, 0], float(t[ends[1]] - t[ends[0]])


PLAIN = {"jjf2003": plain_2003, "joint": plain_joint, "jjf1536": plain_1536}
