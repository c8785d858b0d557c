"""Closed formulas of the type B contributions of each item, independent of the product's.

Everything is in SI; `Contribution.scaled` turns it into the unit that is printed. Appendix A of
both specifications gives the table one relative uncertainty with sensitivity 1 for every item.
Here each limit has the sensitivity that the item's own equation gives it; where the
specification is silent the docstring says `silent` and derives it.

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
from tasks.uncertainty.budget import Contribution
from tasks.uncertainty.equipment import Equipment, ErrorLimit
from tasks.words import message

MIN_RIPPLE_ANGLE = math.sqrt(2.0)  # rad: over a smaller one a ripple does not average out
ROUNDING = 1e-12  # of a sum: what is less is zero


@dataclass(frozen=True)
class Weights:
    """The weights in a result of the readings that an attitude error affects.

    rests: (n,), each rest by itself; faces: (m,), each face (one axis up, all headings). mountings:
    (…,), each error of the fixture: the faces if every one is mounted separately; with one mounting
    the difference of each axis up and down, since one tilt has opposite signs there.
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
    c = slope·√Σ(oₖXₖ/Θₖ)², and a/√2 of less than √2 (silent). Polled encoders: beginning and end
    of a point of Tₖ are each off by a time of their own, c = slope·√(2Σ(oₖXₖ/Tₖ)²) (silent).
    """
    weights = operator * rates
    belongs = [equipment.rate_at(float(rate)) for rate in rates]
    lines: list[Contribution] = []
    for _, limit in equipment.rates:
        held = np.array([limit in limits for limits in belongs])
        if held.any():
            total = float(weights[held].sum())
            balanced = abs(total) < ROUNDING * float(np.abs(weights[held]).sum())
            lines += _lines(0.0 if balanced else -slope * total, limit)
    turned = np.maximum(np.abs(rates) * seconds, MIN_RIPPLE_ANGLE)
    lines += _lines(slope * float(np.linalg.norm(weights / turned)), equipment.ripple)
    timed = slope * math.sqrt(2.0) * float(np.linalg.norm(weights / seconds))
    return (*lines, *_lines(timed, equipment.encoder_time))


def turned_angle(
    equipment: Equipment, slope: float, angles: np.ndarray
) -> tuple[Contribution, ...]:
    """What the table's angles do to K_ij from turns by known angles (n,), rad.

    The mean of n turns, each angle wrong by an error of its own: c = K_ij/n·√Σ1/θₖ² (silent). It
    is another error than that of the axis's direction, so it has a symbol of its own.
    """
    c = slope * float(np.linalg.norm(1.0 / angles)) / len(angles)
    turned = (
        replace(
            limit,
            symbol=f"{limit.symbol}θ",
            name=message("uncertainty-turned-angle", limit=limit.name),
        )
        for limit in equipment.angles
    )
    return _lines(c, *turned)


def turning_axis(equipment: Equipment, *across: float) -> tuple[Contribution, ...]:
    """What the direction of the rotation axis does to K_ij of 7.2.1 and 7.2.3, per radian.

    The gyro reads K·(ω along its axes), so an input axis off by α adds α·ω to the gyro's other
    inputs: c = √Σ K_ik² over the axes k ≠ j turned about. For a cross coupling that is K_ii
    itself, for a scale factor only its cross couplings (silent). One mounting for all rates, so
    nothing averages.
    """
    return _lines(math.hypot(*across), *equipment.angles, *_squareness(equipment))


def attitude_errors(
    equipment: Equipment, per_radian: float, weights: Weights
) -> tuple[Contribution, ...]:
    """What attitude errors do to a parameter of the positions, eq. (8) and (11).

    per_radian: what an error α of one position changes its reading by, divided by α; table
    angles are independent in every rest, table axes in every face, the fixture in every mounting.
    All are silent.

    B of a gyro: α changes the Earth rate on the axis by ωe·α, so K·ωe: c = K·ωe/√12 for table
    angles, K·ωe/√6 for what each face has of its own, 0 for one mounting. Earth's rotation itself
    cancels over the twelve positions, so latitude does not enter.
    g_ij: α also adds α·g to the two other columns, so √((K·ωe)² + Σ g_ik²) over the other axes k:
    halved for table angles (four positions), by √2 for what each of two faces has of its own,
    whole for one mounting.
    K_ii of an accelerometer: α acts through the cross couplings only, √Σ K_ik²; K_ij: a vertical
    off by α puts g·α on axis i, so K_ii. Both are divided as g_ij is.
    B of an accelerometer: the axis lies level in four of six faces, whose weights these are, and
    α reads K·g·α there: c = K·g·√8/12 for table angles, K·g·√4/6 for what each face has of its
    own. One mounting cancels between up and down, and so does gravity itself.
    """
    rest, face, mounting = (
        per_radian * float(np.linalg.norm(part))
        for part in (weights.rests, weights.faces, weights.mountings)
    )
    return (
        *_lines(rest, *equipment.angles),
        *_lines(face, equipment.axes),
        *_lines(0.0 if mounting < ROUNDING else mounting, equipment.fixture),
    )


def gravity_error(equipment: Equipment, k: float, gravity: float) -> tuple[Contribution, ...]:
    """What gravity does to K of eq. (11), (U_up − U_down)/(2g): c = −K/g."""
    return _lines(-k / gravity, equipment.gravity)


def earth_removed(equipment: Equipment, k: float, latitude: float) -> tuple[Contribution, ...]:
    """What the latitude (rad) does to g_ii once K·ωe·sin φ was taken from it: c = −K·ωe·cos φ."""
    return _lines(-k * EARTH_RATE * math.cos(latitude), equipment.latitude)


def accel_rate_sensitivity(
    equipment: Equipment, p: float, rate: float, gravity: float
) -> tuple[Contribution, ...]:
    """p of eq. (12), (U₇ − U₈)/ω²; metres, rate in rad/s.

    c(ε) = −2p, eq. (A.12). A rotation axis off the vertical by α reads K·g·α at rest and averages
    out while turning: c = g/ω² with K near one (silent). The value of the clause holds for the
    unit's place on the table, so how well it is centred does not enter.
    """
    tilted = (*equipment.angles, equipment.axes)
    return _lines(-2.0 * p, *equipment.rate_at(rate)) + _lines(gravity / rate**2, *tilted)


def ahrs_zero_offset(
    equipment: Equipment, seconds: float, positions: int = 4
) -> tuple[Contribution, ...]:
    """B of JJF 1536-2015 eq. (16), ΣN/(n·T) over n positions; rad/s.

    Each N counts with 1/(n·T). A table angle that is not held to α moves it by α:
    c = 1/(√n·T), 1/(2T) for four; an axis off its heading by the fixture's α reads ωe·α·T:
    c = ωe/√n (silent).
    """
    share = 1.0 / math.sqrt(positions)
    angles = _lines(share / seconds, *equipment.angles)
    return angles + _lines(share * EARTH_RATE, *_squareness(equipment))


def ahrs_misalignment(
    equipment: Equipment, misalignment: float, k: float, shares: np.ndarray, angles: np.ndarray
) -> tuple[Contribution, ...]:
    """L of eq. (7) to (9) and (17), Σ sₖNₖ/Σ sₖθₖ over turns by θₖ (n,) rad, as a ratio (rad).

    shares: s (n,), +1 and −1 for one turn each way. A turned angle wrong by α changes the
    divisor: c = −L·√Σsₖ²/Σsₖθₖ, −L/(360°·n)/√2 for two turns of n·360°. An axis off its
    heading by the fixture's α turns the axis that reads, whose scale factor is K, by α of each
    turn: c = K (silent).
    """
    c = -misalignment * float(np.linalg.norm(shares) / (shares @ angles))
    return _lines(c, *equipment.angles) + _lines(k, *_squareness(equipment))


def _squareness(equipment: Equipment) -> tuple[ErrorLimit, ...]:
    """What turns the unit by an error common to all positions of one mounting, rad."""
    return tuple(limit for limit in (equipment.axes, equipment.fixture) if limit is not None)


def _lines(sensitivity: float, *limits: ErrorLimit | None) -> tuple[Contribution, ...]:
    """A line for each limit that is known."""
    return tuple(Contribution(limit.quantity, sensitivity) for limit in limits if limit is not None)
