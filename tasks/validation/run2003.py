"""A whole JJF 2003 run of a simulated unit: twelve positions, ten rates about each axis, rests."""

import numpy as np

from schemas.recording import ACCEL, AXES, GYRO, Recording
from tasks.station.virtual.config import DEGREE, EARTH_RATE_RAD_S
from tasks.uncertainty.equipment import JJF2003
from tasks.validation.record import WITHOUT_EARTH
from tasks.validation.simulated_units import (
    Journey,
    SimulatedUnit,
    Site,
    TableErrors,
    recording_of,
    sensed_rates,
)

RATE_HZ = 20.0
DWELL_S, WHOLE_TURNS_S = 30.0, 36.0  # of a point; in which every rate makes whole turns
RATES = (-300.0, -200.0, -100.0, -50.0, -10.0, 10.0, 50.0, 100.0, 200.0, 300.0)
PLACES = {  # middle and inner angle, degrees, that bring an axis up
    "+x": (90.0, 90.0), "-x": (90.0, -90.0), "+y": (90.0, 0.0), "-y": (90.0, 180.0),
    "+z": (0.0, 0.0), "-z": (180.0, 0.0),
}  # fmt: skip


def record(
    simulated: SimulatedUnit, number: int = 0
) -> tuple[Recording, dict[str, dict[str, float]]]:
    """A simulated unit's recording, and the truth of each element of every item, in printed units.

    Errors of Table 1: the rate's for the run; the outer axis off the vertical, axes that are not
    square and one fixture for the run; of each axis an error at each angle, and one each time that
    it is set. An ideal table makes whole turns, over which the level part of Earth's
    rotation averages out.
    """
    errors = TableErrors(
        rate=simulated.error(*JJF2003.rate_at(RATES[0] * DEGREE)),
        ripple=simulated.error(JJF2003.ripple),
        phase=simulated.random.uniform(0.0, 2.0 * np.pi),
        level=tuple(simulated.errors(2, JJF2003.level)),
        joints=tuple(simulated.errors(2, JJF2003.axes)),
    )
    site = simulated.site(JJF2003.gravity, JJF2003.latitude)
    journey = _journey(simulated)
    track = journey.track()
    read = sensed_rates(track, errors, site, simulated.unit, simulated.noise())
    imu = dict(zip(GYRO + ACCEL, read, strict=True))
    return recording_of("JJF 2003-2022", number, journey, imu, track[:3, ::2]), truth(
        simulated, site
    )


def truth(simulated: SimulatedUnit, site: Site) -> dict[str, dict[str, float]]:
    """What each item of JJF 2003 should find of a unit: element to value, in printed units.

    The clause's g-sensitivity and the fit offset hold Earth's rotation, as their equations do;
    WITHOUT_EARTH does not.
    """
    unit, K = simulated.unit, np.array(simulated.unit.gyro.scale)
    bias, still = np.array(unit.gyro.bias), np.array(unit.g_sensitivity) * site.gravity
    felt = still + K * EARTH_RATE_RAD_S * np.sin(site.latitude)
    p = -unit.rate_sensitivity_m
    K_accel, bias_accel = np.array(unit.accel.scale), np.array(unit.accel.bias)
    items = printed_items(K, bias + np.diag(felt), bias, felt, K_accel, bias_accel, p)
    return {**items, WITHOUT_EARTH: matrix(still / DEGREE)}


def _journey(simulated: SimulatedUnit) -> Journey:
    journey, dwell = Journey(RATE_HZ), WHOLE_TURNS_S if simulated.ideal else DWELL_S
    fixture, table = simulated.errors(3, JJF2003.fixture), SetAngles(simulated)
    for up, (middle, inner) in PLACES.items():
        for turn in (0.0, 180.0):
            table.set(journey, (turn, middle, inner), fixture)
            label = {"name": f"position_{up}_{turn:03.0f}", "kind": "static", "up": up,
                     "item": "twelve_position", "turn_deg": turn}  # fmt: skip
            journey.stay(dwell, label)
    for axis in AXES:
        up = f"+{axis}"
        middle, inner = PLACES[up]
        table.set(journey, (0.0, middle, inner), fixture)
        rest = {"kind": "static", "item": "rate_sensitivity", "up": up}
        journey.stay(dwell, {"name": f"rest_before_{axis}", **rest})
        for rate in RATES:
            journey.change_rate(rate * DEGREE)
            label = {"name": f"rate_{axis}_{rate:+.0f}", "kind": "rate", "item": "scale_factor",
                     "axis": axis, "up": up, "rate_deg_s": rate}  # fmt: skip
            journey.stay(dwell, label)
        journey.change_rate(0.0)
        journey.stay(dwell, {"name": f"rest_after_{axis}", **rest})
    return journey


class SetAngles:
    """What each axis of a table is off by: at each angle, and each time that it is set."""

    def __init__(self, simulated: SimulatedUnit) -> None:
        self._simulated = simulated
        self._at: dict[tuple[int, float], float] = {}
        self._last: list[float | None] = [None] * 3
        self._set = np.zeros(3)

    def set(
        self, journey: Journey, degrees: tuple[float, float, float], mounted: np.ndarray
    ) -> None:
        """Moves to these angles of the axes, outermost first."""
        errors = np.zeros(3)
        for axis, angle in enumerate(degrees):
            place = axis, angle % 360.0
            if place not in self._at:
                self._at[place] = self._simulated.error(JJF2003.position)
            if angle != self._last[axis]:
                self._set[axis] = self._simulated.error(JJF2003.repeatability)
                self._last[axis] = angle
            errors[axis] = self._at[place] + self._set[axis]
        outer, middle, inner = (angle * DEGREE for angle in degrees)
        journey.place(outer, middle, inner, mounted, errors)


def printed_items(
    K_gyro: np.ndarray,
    offset: np.ndarray,
    bias_gyro: np.ndarray,
    g_sensitivity: np.ndarray,
    K_accel: np.ndarray,
    bias_accel: np.ndarray,
    p: np.ndarray,
) -> dict[str, dict[str, float]]:
    """Every item of JJF 2003 by its elements, in printed units.

    Of arrays (3, 3), of offset and biases (3,), in rad/s, rad/s per g, m/s² and m.
    """
    return {
        "gyro_scale_factor": vector(np.diag(K_gyro)),
        "gyro_cross_coupling": matrix(K_gyro, off_diagonal=True),
        "gyro_fit_offset": vector(offset / DEGREE),
        "gyro_bias": vector(bias_gyro / DEGREE),
        "gyro_g_sensitivity": matrix(g_sensitivity / DEGREE),
        "accel_scale_factor": vector(np.diag(K_accel)),
        "accel_cross_coupling": matrix(K_accel, off_diagonal=True),
        "accel_bias": vector(bias_accel),
        "accel_rate_sensitivity": matrix(p, off_diagonal=True),
    }


def vector(values: np.ndarray) -> dict[str, float]:
    """Elements of a (3,) vector."""
    return {axis: float(value) for axis, value in zip(AXES, values, strict=True)}


def matrix(values: np.ndarray, off_diagonal: bool = False) -> dict[str, float]:
    """Elements of a (3, 3) matrix: the axis that reads, then the input axis."""
    return {
        AXES[i] + AXES[j]: float(values[i, j])
        for i in range(3)
        for j in range(3)
        if i != j or not off_diagonal
    }
