"""Type B contributions of each calibration item: equipment limits times sensitivities.

Everything is in SI; `Contribution.scaled` turns it into the unit that is printed. Appendix A of
both specifications gives the table one relative uncertainty with sensitivity 1 for every item.
Here each limit has the sensitivity that the item's own equation gives it; where the
specification is silent the docstring says «silent» and derives it.

Angles are of three sorts. A table angle has an error of its own in every position, so that the
mean over n positions has it divided by √n. Table axes that are not square tilt each face
differently, by how the table has to stand for it. A fixture is wrong by the same angle for as long
as the unit stays mounted: in all positions of a recording with one mounting, else in each face
anew. Cosine errors (α²/2 ≈ 1e-9 for 10″) are left out.

A sensitivity is the derivative by the estimate of the input, at the stated value.
Where several independent errors of one limit act it is their root sum of squares, never negative.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from tasks.motion.table import EARTH_RATE
from tasks.uncertainty.budget import Contribution, InputQuantity
from tasks.uncertainty.equipment import Equipment, Limit
from tasks.words import message

MIN_RIPPLE_ANGLE = math.sqrt(2.0)  # rad: over a smaller one a ripple does not average out
HEADINGS = 2  # at which 7.2.2.1 holds each face
ROUNDING = 1e-12  # of a sum: what is less is zero


@dataclass(frozen=True)
class Weights:
    """How much the readings that an attitude error reaches count in a result.

    rests: (n,), each rest by itself; faces: (m,), each face (one axis up, all headings).
    mountings: (…,), each error of the fixture: the faces where every one is mounted anew; with one
    mounting the difference of each axis up and down, to which one tilt goes with opposite signs.
    """

    rests: np.ndarray
    faces: np.ndarray
    mountings: np.ndarray


def turning_rate(
    equipment: Equipment, slope: float, operator: np.ndarray, rates: np.ndarray, seconds: np.ndarray
) -> tuple[Contribution, ...]:
    """What the table's rate does to a parameter θ = o·U of a line, with U = slope·X.

    JJF 2003 eq. (5), JJF 1536 eq. (14). slope: K_ij; operator, rates (rad/s), seconds: (n,), of
    each rate point.
    Whole turns: the relative error ε is common to all points that one limit holds for,
    c = −slope·Σ oₖXₖ over them (−K for a scale factor or coupling, 0 for the fit offset); this is
    c(Ω) of JJF 1536, eq. (A.2). Within a turn: a ripple a·cos θ leaves a/Θ of its mean over the
    angle Θ turned, as root mean square over where it starts and stops, differently at each point:
    c = slope·√Σ(oₖXₖ/Θₖ)², and a/√2 of less than √2 (silent).
    """
    weights = operator * rates
    belongs = [equipment.rate_at(float(rate))[:1] for rate in rates]
    lines = []
    for _, limit in equipment.rates:
        held = np.array([limit in limits for limits in belongs])
        if held.any():
            total = float(weights[held].sum())
            balanced = abs(total) < ROUNDING * float(np.abs(weights[held]).sum())
            lines.append(_line(limit, 0.0 if balanced else -slope * total))
    if equipment.ripple is not None:
        turned = np.maximum(np.abs(rates) * seconds, MIN_RIPPLE_ANGLE)
        lines.append(_line(equipment.ripple, slope * float(np.linalg.norm(weights / turned))))
    return tuple(lines)


def turned_angle(
    equipment: Equipment, slope: float, angles: np.ndarray
) -> tuple[Contribution, ...]:
    """What the table's angles do to K_ij from turns by known angles (n,), rad.

    The mean of n turns, each angle wrong by an error of its own: c = K_ij/n·√Σ1/θₖ² (silent). It
    is another error than that of the axis's direction, so it has a symbol of its own.
    """
    c = slope * float(np.linalg.norm(1.0 / angles)) / len(angles)
    return tuple(
        _line(
            replace(
                limit,
                symbol=f"{limit.symbol}θ",
                name=message("uncertainty-turned-angle", limit=limit.name),
            ),
            c,
        )
        for limit in equipment.angles
    )


def turning_axis(equipment: Equipment, *across: float) -> tuple[Contribution, ...]:
    """What the direction of the rotation axis does to K_ij of 7.2.1 and 7.2.3, per radian.

    The gyro reads K·(ω along its axes), so an input axis off by α adds α·ω to the gyro's other
    inputs: c = √Σ K_ik² over the axes k ≠ j turned about. For a cross coupling that is K_ii
    itself, for a scale factor only its cross couplings (silent). One mounting for all rates, so
    nothing averages.
    """
    c = math.hypot(*across)
    return tuple(_line(limit, c) for limit in (*equipment.angles, *equipment.squareness))


def gyro_bias(equipment: Equipment, weights: Weights, k: float = 1.0) -> tuple[Contribution, ...]:
    """B of eq. (8), mean of the positions; rad/s.

    An attitude error α changes the Earth rate on the axis by ωe·α: c = K·ωe/√12 for table
    angles, K·ωe/√6 for what each face has of its own, 0 for one mounting. Earth's rotation itself
    cancels over the twelve positions, so latitude does not enter (silent).
    """
    return _of_each_face(equipment, k * EARTH_RATE, weights)


def gyro_g_sensitivity(
    equipment: Equipment, weights: Weights, k: float = 1.0, across: float = 0.0
) -> tuple[Contribution, ...]:
    """g_ij of eq. (8), (U_up − U_down)/2; rad/s per g.

    An attitude error α changes the Earth rate on the axis by ωe·α and adds α·g to the two other
    columns: c = √((K·ωe)² + across²), halved for table angles (four positions), by √2 for what
    each of two faces has of its own, whole for one mounting. across: √Σ g_ik² over the other axes
    k (silent).
    """
    return _of_each_face(equipment, math.hypot(k * EARTH_RATE, across), weights)


def earth_removed(equipment: Equipment, k: float, latitude: float) -> tuple[Contribution, ...]:
    """What the latitude (rad) does to g_ii once K·ωe·sin φ was taken from it: c = −K·ωe·cos φ."""
    return (_line(equipment.latitude, -k * EARTH_RATE * math.cos(latitude)),)


def accel_scale_factor(
    equipment: Equipment, weights: Weights, k: float, gravity: float, across: float = 0.0
) -> tuple[Contribution, ...]:
    """K_ii of eq. (11), (U_up − U_down)/(2g).

    c(g) = −K/g. An attitude error α acts through the cross couplings only, c = across =
    √Σ K_ik², halved for table angles, by √2 for each face, whole for one mounting (silent).
    """
    lines = _of_each_face(equipment, across, weights)
    return (_line(equipment.gravity, -k / gravity), *lines)


def accel_cross_coupling(
    equipment: Equipment, weights: Weights, k_ii: float, k_ij: float, gravity: float
) -> tuple[Contribution, ...]:
    """K_ij of eq. (11), (U_i(j up) − U_i(j down))/(2g).

    A vertical off by α puts g·α on axis i: c = K_ii for one mounting, K_ii/√2 for what each of two
    faces has of its own, K_ii/2 for table angles (four positions); c(g) = −K_ij/g (silent).
    """
    lines = _of_each_face(equipment, k_ii, weights)
    return (_line(equipment.gravity, -k_ij / gravity), *lines)


def accel_bias(
    equipment: Equipment, weights: Weights, k: float, gravity: float
) -> tuple[Contribution, ...]:
    """B of eq. (11), mean over the positions; m/s².

    weights: of the positions in which the axis lies level, four of six faces; there α reads
    K·g·α: c = K·g·√8/12 for table angles, K·g·√4/6 for what each face has of its own. One mounting
    cancels between up and down, and so does gravity itself (silent).
    """
    return _of_each_face(equipment, k * gravity, weights)


def accel_rate_sensitivity(
    equipment: Equipment, p: float, rate: float, gravity: float, k: float = 1.0
) -> tuple[Contribution, ...]:
    """p of eq. (12), (U₇ − U₈)/ω²; metres, rate in rad/s.

    c(ε) = −2p, eq. (A.12). A rotation axis off the vertical by α reads K·g·α at rest and averages
    out while turning: c = K·g/ω² (silent). The value of the clause holds for the unit's place on
    the table, so how well it is centred does not enter.
    """
    tilt = k * gravity / rate**2
    lines = [_line(limit, -2.0 * p) for limit in equipment.rate_at(rate)]
    lines.extend(_line(limit, tilt) for limit in equipment.angles)
    if equipment.axes is not None:
        lines.append(_line(equipment.axes, tilt))
    return tuple(lines)


def ahrs_zero_offset(
    equipment: Equipment, seconds: float, positions: int = 4
) -> tuple[Contribution, ...]:
    """B of JJF 1536-2015 eq. (16), ΣN/(n·T) over n positions; rad/s.

    Each N counts with 1/(n·T). A table angle that is not held to α moves it by α:
    c = 1/(√n·T), 1/(2T) for four; an axis off its heading by the fixture's α reads ωe·α·T:
    c = ωe/√n (silent).
    """
    share = 1.0 / math.sqrt(positions)
    angles = tuple(_line(limit, share / seconds) for limit in equipment.angles)
    return angles + tuple(_line(limit, share * EARTH_RATE) for limit in equipment.squareness)


def ahrs_misalignment(
    equipment: Equipment, misalignment: float, shares: np.ndarray, angles: np.ndarray
) -> tuple[Contribution, ...]:
    """L of eq. (7) to (9) and (17), Σ sₖNₖ/Σ sₖθₖ over turns by θₖ (n,) rad, as a ratio (rad).

    shares: s (n,), +1 and −1 for one turn each way. A turned angle wrong by α changes the
    divisor: c = −L·√Σsₖ²/Σsₖθₖ, −L/(360°·n)/√2 for two turns of n·360°. The fixture carries over
    whole: c = 1 (silent).
    """
    c = -misalignment * float(np.linalg.norm(shares) / (shares @ angles))
    lines = tuple(_line(limit, c) for limit in equipment.angles)
    return lines + tuple(_line(limit, 1.0) for limit in equipment.squareness)


def resolution(half_width: float, unit: str, sensitivity: float) -> Contribution:
    """The unit's own resolution: readings rounded to a step, half-width step/2 (GUM F.2.2.1).

    sensitivity: ‖o‖ for means with the weights o that are each rounded by an error of their own.
    For a unit whose noise is above its step, averaging removes it and the type A line already
    holds it.
    """
    u = half_width / math.sqrt(3.0)
    name = message("uncertainty-resolution")
    quantity = InputQuantity("q", name, unit, u, "B", "rectangular")
    return Contribution(quantity, sensitivity)


def tilt_of_a_face(equipment: Equipment, mounted_once: bool) -> float:
    """Variance (rad²) of the tilt that a face has of its own: table angles halved by two headings.

    A fixture that is mounted once tilts all faces alike.
    """
    angles = sum(limit.u**2 for limit in equipment.angles) / HEADINGS
    own = (equipment.axes, None if mounted_once else equipment.fixture)
    return angles + sum(limit.u**2 for limit in own if limit is not None)


def _of_each_face(
    equipment: Equipment, per_radian: float, weights: Weights
) -> tuple[Contribution, ...]:
    """What a mean over faces takes over of table angles, table axes and fixture."""
    rest = per_radian * float(np.linalg.norm(weights.rests))
    face = per_radian * float(np.linalg.norm(weights.faces))
    mounting = per_radian * float(np.linalg.norm(weights.mountings))
    lines = [_line(limit, rest) for limit in equipment.angles]
    if equipment.axes is not None:
        lines.append(_line(equipment.axes, face))
    if equipment.fixture is not None:
        lines.append(_line(equipment.fixture, 0.0 if mounting < ROUNDING else mounting))
    return tuple(lines)


def _line(limit: Limit, sensitivity: float) -> Contribution:
    return Contribution(limit.quantity(), sensitivity)
