"""A specification's requirements on every point and on the environment."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Conditions:
    """Numbers of a specification and the clauses they come from.

    dwell_s: least time at each point, s. steadiness: relative change of a held rate.
    temperature_degc, humidity_percent: lowest and highest value of the air.
    """

    dwell_s: float
    dwell_clause: str
    steadiness: float
    steadiness_clause: str
    temperature_degc: tuple[float, float]
    humidity_percent: tuple[float, float]
    environment_clause: str
