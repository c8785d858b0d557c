"""How long a table takes, and where it should stop."""

from math import sqrt


def move_s(distance_deg: float, rate_deg_s: float, acceleration_deg_s2: float) -> float:
    """Duration of a trapezoidal move over a distance, s."""
    distance = abs(distance_deg)
    ramp = rate_deg_s**2 / acceleration_deg_s2
    if distance < ramp:
        return 2 * sqrt(distance / acceleration_deg_s2)
    return distance / rate_deg_s + rate_deg_s / acceleration_deg_s2


def rate_change_s(change_deg_s: float, acceleration_deg_s2: float) -> float:
    """Duration of a change of rate, s."""
    return abs(change_deg_s) / acceleration_deg_s2


def nearest_turn(angle_deg: float, target_deg: float) -> float:
    """The angle equal to the target but for whole turns that lies nearest, deg.

    Encoders run on past whole turns, and an axis that has spun need not unwind (the tables of
    JJF 2003 table 1 turn without limit).
    """
    return target_deg + 360.0 * round((angle_deg - target_deg) / 360.0)
