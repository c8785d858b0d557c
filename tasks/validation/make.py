"""Makes the validation record: all evidence for every item of every method."""

import time
from collections.abc import Callable
from datetime import date
from importlib import import_module
from typing import Any

import numpy as np
from scipy.linalg import cholesky, qr, solve_triangular
from scipy.spatial.transform import Rotation

from schemas.base import Unusable
from schemas.calibration import (
    Budget,
    Check,
    Evidence,
    Item,
    ItemValidation,
    MethodValidation,
    ValidationRecord,
)
from schemas.recording import ACCEL, ANGLE, AXES, GYRO, Recording, Segment
from tasks.calibrate.calibrate import evaluation_for
from tasks.specifications.evidence import gather
from tasks.specifications.joint.solution import segment_motion, solve_jointly
from tasks.validation.coverage import (
    EXAMPLES,
    Calibrate,
    coverage_check,
    example_check,
    recovery_checks,
    simulate,
    study,
)
from tasks.validation.fingerprint import fingerprint, names_of, text_digest
from tasks.validation.record import checked, clause_item
from tasks.validation.run2003 import matrix, printed_items, vector
from tasks.validation.scenarios import study_scenarios
from tasks.words import message

# An independent least-squares solution of the joint method, for comparison: QR on plain means.
#
# The model, the means, the motion and the solution are made here from the labels and the table's
# angles alone. Only the weights are the method's own: the covariance of the means.

EARTH = 7.292115e-5  # rad/s
ROUNDS = 12
DEGREE = np.pi / 180.0
Values = dict[str, dict[str, float]]


def plain_joint(recording: Recording) -> Values:
    """Every item of JJF 2003 by the joint method, in printed units.

    recording: a run of `run2003`, whose table turns about z, x, z from the outside in.
    """
    station, segments = recording.manifest.station, recording.manifest.segments or ()
    gravity = float(station.gravity_m_s2 or np.nan)
    means, rows = segment_means(recording)
    up, earth = _vertical_and_earth_rate(recording, rows, np.radians(station.latitude_deg or 0.0))
    rate = np.array([[(s.axis == a) * (s.rate_deg_s or 0.0) * DEGREE for a in AXES]
                     for s in segments])  # fmt: skip
    at_rest = np.array([s.kind == "static" for s in segments])
    covariance = _weights(recording)
    one = np.ones((len(segments), 1))
    K, bias, g = np.eye(3), np.zeros(3), np.zeros((3, 3))
    for _ in range(ROUNDS):
        still = means[:, :3] - earth @ K.T
        new = [_gyro(rate, up, at_rest, still[:, i], covariance[i], one) for i in range(3)]
        K, bias, g = (np.array(part) for part in zip(*new, strict=True))
    design = np.hstack([gravity * up, one, (rate + earth) ** 2])
    accel = np.array([_gls(design, means[:, 3 + i], covariance[3 + i]) for i in range(3)])
    read = means[:, :3] - rate @ K.T
    offset = [read[[s.kind == "rate" and s.axis == a for s in segments], i].mean()
              for i, a in enumerate(AXES)]  # fmt: skip
    return printed_items(K, np.array(offset), bias, g, accel[:, :3], accel[:, 3], -accel[:, 4:])


def segment_means(recording: Recording) -> tuple[np.ndarray, list[np.ndarray]]:
    """Plain means (n, 6) of gyros and accelerometers, and which rows (bool) each segment has."""
    t = recording.imu.t
    rows = [(t >= s.t_start) & (t < s.t_end) for s in recording.manifest.segments or ()]
    columns = np.array([recording.imu.columns[name] for name in GYRO + ACCEL])
    return np.array([columns[:, which].mean(axis=1) for which in rows]), rows


def _gyro(
    rate: np.ndarray,
    up: np.ndarray,
    at_rest: np.ndarray,
    read: np.ndarray,
    covariance: np.ndarray,
    one: np.ndarray,
) -> tuple[np.ndarray, float, np.ndarray]:
    """K (3,), bias and g-sensitivity (3,) per g: the rests first, then all with those
    subtracted.
    """
    both = np.hstack([one, up])
    block = covariance[np.ix_(at_rest, at_rest)]
    zero = _gls(both[at_rest], read[at_rest], block)
    pick = np.zeros((4, len(read)))
    unit = np.eye(int(at_rest.sum()))
    pick[:, at_rest] = np.column_stack([_gls(both[at_rest], e, block) for e in unit])
    left = np.eye(len(read)) - up @ pick[1:]
    line = _gls(np.hstack([rate, one]), left @ read, left @ covariance @ left.T)
    return line[:3], float(zero[0]), zero[1:]


def _gls(design: np.ndarray, read: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """Generalised least squares: the smallest (y − Hθ)ᵀ·C⁻¹·(y − Hθ), by a QR decomposition.

    No variance counts as less than a tenth of the median one, as the method has it.
    """
    variance = np.diag(covariance)
    floor = 0.1 * np.median(variance)
    raised = np.maximum(variance, floor)
    root = cholesky(covariance + np.diag(raised - variance + 1e-9 * raised), lower=True)
    scale = np.abs(design).max(axis=0)
    white = solve_triangular(root, np.column_stack([design / scale, read]), lower=True)
    q, r = qr(white[:, :-1], mode="economic")
    return np.asarray(solve_triangular(r, q.T @ white[:, -1]) / scale)


def _vertical_and_earth_rate(
    recording: Recording, rows: list[np.ndarray], latitude: float
) -> tuple[np.ndarray, np.ndarray]:
    """Mean vertical and mean Earth rotation (n, 3), rad/s, in the body, by the table's angles."""
    assert recording.table is not None
    angles = np.array(list(recording.table.columns.values())).T
    body = Rotation.from_euler("ZXZ", angles).inv()
    up = body.apply([0.0, 0.0, 1.0])
    earth = body.apply(EARTH * np.array([0.0, np.cos(latitude), np.sin(latitude)]))
    return (
        np.array([up[which].mean(axis=0) for which in rows]),
        np.array([earth[which].mean(axis=0) for which in rows]),
    )


def _weights(recording: Recording) -> np.ndarray:
    evidence = gather(recording)
    equipment = evaluation_for(recording).equipment
    return solve_jointly(evidence, segment_motion(evidence), equipment).covariance


# Other programs on the same data: plain least squares for values, GTC for the budgets.

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


FEWER = 10  # times fewer units in each scenario than in order


def make_record(
    methods: dict[str, Calibrate],
    units: int,
    seed: int,
    code_version: str,
    report: Callable[[int, int], None],
) -> ValidationRecord:
    """All evidence for every item of the methods; the coverage over as many simulated units.

    Raises Unusable where GTC is not installed, and for an item without a worked example.
    """
    began = time.monotonic()
    recovered = {m: recovery_checks(m, calibrate, seed) for m, calibrate in methods.items()}
    items_made = {clause_item(name) for of_method in recovered.values() for name in of_method}
    if lacking := sorted(items_made - EXAMPLES.keys()):
        raise Unusable(
            f"EXAMPLES in tasks/validation/coverage.py has no worked example for "
            f"{', '.join(lacking)}: add one before the study of {units} units"
        )
    independent = {m: independent_checks(m, calibrate, seed) for m, calibrate in methods.items()}
    methods_made = {}
    for method, coverages in study(methods, units, seed, report).items():
        items = {}
        for name, coverage in coverages.items():
            item = clause_item(name)
            checks: dict[Evidence, Check] = {
                "worked example": example_check(item),
                "coverage": coverage_check(coverage),
            }
            if name in recovered[method]:
                checks["truth recovery"] = recovered[method][name]
            if item in independent[method]:
                checks["independent program"] = independent[method][item]
            items[name] = ItemValidation(checks=checks, coverage=coverage)
        names = names_of(method)
        methods_made[method] = MethodValidation(
            fingerprint=fingerprint(method), sources=names, text=text_digest(names), items=items
        )
    scenarios = study_scenarios(methods, max(1, units // FEWER), seed, report)
    return ValidationRecord.model_validate(
        {
            "made_on": date.today(),
            "code_version": code_version,
            "seed": seed,
            "seconds": round(time.monotonic() - began, 1),
            "methods": methods_made,
            "scenarios": scenarios,
        }
    )
