"""Type B contributions of each calibration item: equipment limits times sensitivities.

Everything is in SI; `Contribution.scaled` turns it into the unit that is printed. Appendix A of
both specifications gives the table one relative uncertainty with sensitivity 1 for every item.
Here each limit has the sensitivity that the item's own equation gives it; where the
specification is silent the docstring says «silent» and derives it.

Angles are of two sorts. A table angle has an error of its own in every position, so that the
mean over n positions has it divided by √n. A square fixture or table axis is wrong by the same
angle for as long as the unit stays mounted. Cosine errors (α²/2 ≈ 1e-9 for 10″) are left out.
"""

import math
from collections.abc import Sequence

import numpy as np

from tasks.motion.table import EARTH_RATE
from tasks.uncertainty.budget import Contribution, InputQuantity
from tasks.uncertainty.equipment import Equipment, Limit

HEADINGS, FACES = 2, 6  # 7.2.2.1: six axes up, each at two headings
TURN = 2.0 * math.pi


def turning_rate(
    equipment: Equipment, slope: float, operator: np.ndarray, rates: np.ndarray, seconds: np.ndarray
) -> tuple[Contribution, ...]:
    """What the table's rate does to a parameter θ = o·U of eq. (5), with U = slope·X.

    slope: K_ij; operator, rates (rad/s), seconds: (n,), of each rate point.
    Whole turns: the relative error ε is common to all points, c = slope·Σ oₖXₖ (K for a scale
    factor or coupling, 0 for the fit offset). Within a turn: a ripple a·cos θ averages to at
    most 2a/Θ over the angle Θ turned, differently at each point,
    c = slope·√Σ(oₖXₖ·min(1, 2/Θₖ))² (silent).
    """
    weights = operator * rates
    lines = [_line(equipment.rate, slope * float(weights.sum()))]
    if equipment.ripple is not None:
        turned = np.maximum(np.abs(rates) * seconds, 2.0)
        lines.append(_line(equipment.ripple, slope * float(np.linalg.norm(weights * 2.0 / turned))))
    return tuple(lines)


def turning_axis(equipment: Equipment, *across: float) -> tuple[Contribution, ...]:
    """What the direction of the rotation axis does to K_ij of 7.2.1 and 7.2.3, per radian.

    The gyro reads K·(ω along its axes), so an input axis off by α feeds α·ω to the gyro's other
    inputs: c = √Σ K_ik² over the axes k ≠ j turned about. For a cross coupling that is K_ii
    itself, for a scale factor only its cross couplings (silent). One mounting for all rates, so
    nothing averages.
    """
    c = math.hypot(*across)
    return tuple(_line(limit, c) for limit in (*equipment.angles, *equipment.squareness))


def gyro_bias(equipment: Equipment, k: float = 1.0) -> tuple[Contribution, ...]:
    """B of eq. (8), mean of twelve positions; rad/s.

    An attitude error α changes the Earth rate on the axis by ωe·α: c = K·ωe/√12 for table
    angles, K·ωe/√6 for the mounting of each face. Earth's rotation itself cancels over the
    twelve positions, so latitude does not enter (silent).
    """
    earth = k * EARTH_RATE
    return _mean_of_faces(equipment, earth, FACES)


def gyro_g_sensitivity(
    equipment: Equipment, k: float = 1.0, across: float = 0.0, latitude: float | None = None
) -> tuple[Contribution, ...]:
    """g_ij of eq. (8), (U_up − U_down)/2; rad/s per g.

    An attitude error α changes the Earth rate on the axis by ωe·α and feeds α·g to the two other
    columns: c = √((K·ωe)² + across²), halved for table angles (four positions), whole for the
    mounting. across: √Σ g_ik² over the other axes k. latitude (rad): for the diagonal with
    Earth's rotation removed, c(φ) = K·ωe·cos φ; None: the value of the clause (silent).
    """
    c = math.hypot(k * EARTH_RATE, across)
    lines = _up_minus_down(equipment, c)
    if latitude is None:
        return lines
    return (*lines, _line(equipment.latitude, -k * EARTH_RATE * math.cos(latitude)))


def accel_scale_factor(
    equipment: Equipment, k: float, gravity: float, across: float = 0.0
) -> tuple[Contribution, ...]:
    """K_ii of eq. (11), (U_up − U_down)/(2g).

    c(g) = −K/g. An attitude error α acts through the cross couplings only, c = across =
    √Σ K_ik², halved for table angles (silent).
    """
    return (_line(equipment.gravity, -k / gravity), *_up_minus_down(equipment, across))


def accel_cross_coupling(
    equipment: Equipment, k_ii: float, k_ij: float, gravity: float
) -> tuple[Contribution, ...]:
    """K_ij of eq. (11), (U_i(j up) − U_i(j down))/(2g).

    A vertical off by α puts g·α on axis i: c = K_ii for the mounting, K_ii/2 for table angles
    (four positions); c(g) = −K_ij/g (silent).
    """
    return (_line(equipment.gravity, -k_ij / gravity), *_up_minus_down(equipment, k_ii))


def accel_bias(equipment: Equipment, k: float, gravity: float) -> tuple[Contribution, ...]:
    """B of eq. (11), mean over the positions; m/s².

    The axis lies level in four of six faces, where α reads K·g·α: c = K·g·√8/12 for table
    angles, K·g·√4/6 for the mounting of each face. Gravity itself cancels (silent).
    """
    return _mean_of_faces(equipment, k * gravity, FACES - 2)


def accel_rate_sensitivity(
    equipment: Equipment, p: float, rate: float, gravity: float, k: float = 1.0
) -> tuple[Contribution, ...]:
    """p of eq. (12), (U₇ − U₈)/ω²; metres, rate in rad/s.

    c(ε) = −2p, eq. (A.12). A rotation axis off the vertical by α reads K·g·α at rest and averages
    out while turning: c = K·g/ω² (silent). The value of the clause holds for the unit's place on
    the table; for the sensor's own p add `place_on_table`.
    """
    tilt = k * gravity / rate**2
    lines = [_line(equipment.rate, -2.0 * p)]
    lines.extend(_line(limit, tilt) for limit in equipment.angles)
    if equipment.axes is not None:
        lines.append(_line(equipment.axes, tilt))
    return tuple(lines)


def place_on_table(equipment: Equipment, k: float = 1.0) -> Contribution:
    """An accelerometer at r from the rotation axis adds K·r to p of eq. (12): c = K (silent)."""
    return _line(equipment.centring, k)


def ahrs_scale_factor(equipment: Equipment, k: float) -> tuple[Contribution, ...]:
    """K of JJF 1536-2015 eq. (14): c(ε) = −K, eq. (A.2)."""
    return (_line(equipment.rate, -k),)


def ahrs_zero_offset(equipment: Equipment, seconds: float) -> tuple[Contribution, ...]:
    """B of eq. (16), (N₁ + N₂ + N₃ + N₄)/(4T); rad/s.

    Each N counts with 1/(4T). A table angle that is not held to α moves it by α: c = 1/(2T) for
    four positions; an axis off its heading by the fixture's α reads ωe·α·T: c = ωe/2 (silent).
    """
    lines = [_line(limit, 0.5 / seconds) for limit in equipment.angles]
    return (*lines, _line(equipment.fixture, 0.5 * EARTH_RATE))


def ahrs_misalignment(
    equipment: Equipment, misalignment: float, turns: float
) -> tuple[Contribution, ...]:
    """L of eq. (7) to (9), (N₊ − N₋)/(2·360°·n) as a ratio (rad).

    A turned angle wrong by α changes the divisor: c = −L/(360°·n)/√2 for the two turns. The
    fixture carries over whole: c = 1 (silent).
    """
    c = -misalignment / (TURN * turns) / math.sqrt(2.0)
    lines = [_line(limit, c) for limit in equipment.angles]
    return (*lines, _line(equipment.fixture, 1.0))


def resolution(step: float, unit: str, operator: Sequence[float] | np.ndarray) -> Contribution:
    """The unit's own resolution: readings rounded to `step`, half-width step/2 (GUM F.2.2.1).

    operator: weights of the means, each rounded by its own error: c = ‖o‖. For a unit whose
    noise is above its step, averaging removes it and the type A line already holds it.
    """
    quantity = InputQuantity(
        "q", "resolution", "分辨力", unit, step / math.sqrt(12.0), "B", "rectangular"
    )
    return Contribution(quantity, float(np.linalg.norm(operator)))


def step_of(bits: float, full_scale: float) -> float:
    """One step of N effective bits over ± full scale: 2·full_scale/2ᴺ."""
    return 2.0 * full_scale / 2.0**bits


def _mean_of_faces(equipment: Equipment, per_radian: float, faces: int) -> tuple[Contribution, ...]:
    """A mean over all positions in which `faces` of the six faces feel an angle."""
    positions = faces * HEADINGS
    each = per_radian * math.sqrt(positions) / (FACES * HEADINGS)
    face = per_radian * math.sqrt(faces) / FACES
    return _by_sort(equipment, each, face)


def _up_minus_down(equipment: Equipment, per_radian: float) -> tuple[Contribution, ...]:
    """(up − down)/2 with two headings each: four positions with weight 1/4."""
    return _by_sort(equipment, per_radian / 2.0, per_radian)


def _by_sort(equipment: Equipment, each: float, mounting: float) -> tuple[Contribution, ...]:
    angles = tuple(_line(limit, each) for limit in equipment.angles)
    return angles + tuple(_line(limit, mounting) for limit in equipment.squareness)


def _line(limit: Limit, sensitivity: float) -> Contribution:
    return Contribution(limit.quantity(), sensitivity)
