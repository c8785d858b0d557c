"""A whole JJF 1536 run of a simulated unit on a single-axis table, re-fixed between the axes."""

from dataclasses import replace

import numpy as np

from schemas.recording import ANGLE, AXES, Manifest, Recording
from tasks.station.virtual.config import DEGREE
from tasks.uncertainty.equipment import JJF1536
from tasks.validation.run2003 import matrix, vector
from tasks.validation.simulated_units import (
    Journey,
    SimulatedUnit,
    TableErrors,
    accumulated_angles,
    recording_of,
)

RATE_HZ = 4.0
REST_S, RATE_S, POSITION_S, TURNS_S = 20.0, 20.0, 1800.0, 36.0  # 7.1.1, 7.2.1, 7.3.1
RATES = (-300.0, -200.0, -100.0, -10.0, 10.0, 100.0, 200.0, 300.0)
TURNING = 100.0  # deg/s, ten turns in TURNS_S
RATE_LIMIT = JJF1536.rate_at(RATES[0] * DEGREE)
COMPASS = {"E": (1, 0, 0), "W": (-1, 0, 0), "N": (0, 1, 0), "S": (0, -1, 0),
           "U": (0, 0, 1), "D": (0, 0, -1)}  # fmt: skip
UPRIGHT = {"x": "UEN", "y": "NUE", "z": "ENU"}
FOUR = {"x": ("ENU", "ESD", "WSU", "WND"), "y": ("UEN", "DES", "UWS", "DWN"),
        "z": ("NUE", "SDE", "SUW", "NDW")}  # fmt: skip


def record(
    simulated: SimulatedUnit, number: int = 0
) -> tuple[Recording, dict[str, dict[str, float]]]:
    """A simulated unit's recording, and the truth of each element of every item, in printed units.

    Errors of Table 1: the rate's for the run; the fixture's for each mounting; the table's angle
    creeps while a position is held.
    """
    errors = TableErrors(rate=simulated.error(*RATE_LIMIT))
    site = simulated.site(JJF1536.gravity, JJF1536.latitude)
    journey = _journey(simulated)
    angles = accumulated_angles(journey.track(), errors, site, simulated.unit, simulated.noise())
    imu = dict(zip(ANGLE, angles, strict=True))
    K = np.array(simulated.unit.gyro.scale)
    truth = {
        "ahrs_scale_factor": vector(np.diag(K)),
        "ahrs_zero_offset": vector(np.array(simulated.unit.gyro.bias) / DEGREE),
        "ahrs_misalignment": matrix(K / DEGREE, off_diagonal=True),
    }
    recording = recording_of("JJF 1536-2015", number, journey, imu)
    return replace(recording, manifest=with_commanded_rate(recording.manifest)), truth


def with_commanded_rate(manifest: Manifest) -> Manifest:
    """The manifest of a station without encoders, which states Table 1's limit of its rates."""
    (limit,) = RATE_LIMIT
    bound = {"half_width": limit.half_width, "distribution": limit.distribution}
    stated = manifest.model_dump() | {"table_time": {"commanded_rate": bound}}
    return Manifest.model_validate(stated)


def _journey(simulated: SimulatedUnit) -> Journey:
    journey = Journey(RATE_HZ)
    fixed = {axis: simulated.errors(3, JJF1536.fixture) for axis in AXES}
    for axis in AXES:
        upright = {"axis": axis, "up": f"+{axis}"}
        journey.place(*_angles(UPRIGHT[axis]), fixed[axis])
        journey.stay(REST_S, {"name": f"rest_start_{axis}", "kind": "static", **upright,
                              "item": "scale_factor"})  # fmt: skip
        for rate in RATES:
            journey.change_rate(rate * DEGREE)
            journey.stay(RATE_S, {"name": f"rate_{axis}_{rate:+.0f}", "kind": "rate", **upright,
                                  "item": "scale_factor", "rate_deg_s": rate})  # fmt: skip
        journey.change_rate(0.0)
        journey.stay(REST_S, {"name": f"rest_end_{axis}", "kind": "static", **upright,
                              "item": "scale_factor"})  # fmt: skip
    for held, positions in FOUR.items():
        for points in positions:
            journey.place(*_angles(points), simulated.errors(3, JJF1536.fixture))
            journey.stay(POSITION_S, {
                "name": f"zero_{held}_{points}", "kind": "static", "item": "four_position",
                "axis": held, "points": dict(zip(AXES, points, strict=True)),
            }, creep=simulated.errors(3, *JJF1536.angles))  # fmt: skip
    for axis in AXES:
        journey.place(*_angles(UPRIGHT[axis]), fixed[axis])
        for sign in (1.0, -1.0):
            journey.change_rate(sign * TURNING * DEGREE)
            journey.stay(TURNS_S, {
                "name": f"turns_{axis}_{sign:+.0f}", "kind": "rotation", "item": "misalignment",
                "axis": axis, "up": f"+{axis}", "angle_deg": sign * TURNING * TURNS_S,
            })  # fmt: skip
            journey.change_rate(0.0)
    return journey


def _angles(points: str) -> tuple[float, float, float]:
    """Angles about z, then x, then z (rad) that point x, y, z to three letters of the compass."""
    attitude = np.array([COMPASS[letter] for letter in points], float).T
    middle = float(np.arccos(np.clip(attitude[2, 2], -1.0, 1.0)))
    if abs(np.sin(middle)) < 1e-9:
        return float(np.arctan2(attitude[1, 0], attitude[0, 0])), middle, 0.0
    outer = float(np.arctan2(attitude[0, 2], -attitude[1, 2]))
    return outer, middle, float(np.arctan2(attitude[2, 0], attitude[2, 1]))
