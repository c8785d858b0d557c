"""What the joint method says the equipment does to it, against runs in which it does."""

from dataclasses import dataclass

import numpy as np
import pytest

from schemas.calibration import Calibration
from tasks.specifications.joint import JOINT
from tasks.uncertainty.equipment import JJF2003, ErrorLimit
from tasks.validation import run2003
from tasks.validation.simulated_units import SimulatedUnit, draw_simulated_unit
from tests.tasks.items_only import items_only

LIMITS = {
    limit.symbol: limit
    for limit in (JJF2003.rates[0][1], JJF2003.gravity, JJF2003.latitude, JJF2003.fixture)
    if limit is not None
}
SIZES = {"ε1": 1e-4, "g": 1e-2, "φ": 1e-3, "α4": 1e-4}  # in the unit of each limit


@dataclass(frozen=True)
class Planted(SimulatedUnit):
    """A unit with noise on equipment without errors but one: the noise is the same each time."""

    symbol: str = ""
    axis: int = 0

    def error(self, *limits: ErrorLimit | None) -> float:
        wrong = [limit for limit in limits if limit is not None and limit.symbol == self.symbol]
        return SIZES[self.symbol] if wrong and len(limits) == 1 else 0.0

    def errors(self, count: int, *limits: ErrorLimit | None) -> np.ndarray:
        return self.error(*limits) * np.eye(count)[min(self.axis, count - 1)]


def calibrated(symbol: str = "", axis: int = 0) -> Calibration:
    simulated = draw_simulated_unit(4, run2003.RATE_HZ)
    recording, _ = run2003.record(Planted(simulated.unit, simulated.random, False, symbol, axis))
    return items_only(JOINT, recording)


@pytest.fixture(scope="module")
def right() -> Calibration:
    return calibrated()


@pytest.mark.parametrize("symbol", SIZES)
def test_each_value_moves_by_the_error_times_its_sensitivity(right, symbol: str) -> None:
    """To a twentieth of what one standard uncertainty of all equipment does.

    A fixture wrong about each axis: the lines hold the root of the sum of three squares.
    """
    moved = [calibrated(symbol, axis) for axis in range(3 if symbol == "α4" else 1)]
    compared = 0
    for name, item in right.items.items():
        for element, budget in item.budgets.items():
            changes = [each.items[name].value[element] - budget.value for each in moved]
            lines = [line for line in budget.inputs if line.symbol == symbol]
            expected = sum(abs(line.sensitivity) for line in lines) * SIZES[symbol]
            left = 0.05 * budget.u_c * SIZES[symbol] / LIMITS[symbol].u
            assert np.linalg.norm(changes) == pytest.approx(expected, rel=0.05, abs=left), (
                f"{name}.{element}"
            )
            compared += bool(lines)
    assert compared >= {"ε1": 9, "g": 9, "φ": 3, "α4": 12}[symbol]
