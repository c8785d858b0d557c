"""How far the readings may be from those of a fitted time constant that is not well known."""

import numpy as np
import pytest

from tasks.explain.determined import DeterminedModel
from tasks.model.model import Model
from tasks.model.term import nominal_values
from tasks.model.terms.environment import thermal_transient
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.whole import whole_motion

AMPLITUDES = np.array([1e-3, 0.0, 0.0, 0.0, 0.0, 2e-3])  # rad/s, m/s²
TAU = 20.0  # s


@pytest.mark.parametrize("u_tau", [0.02, 8.0, 19.99, 30.0, 1e4])
def test_a_time_constant_no_better_known_than_its_size_moves_readings_by_its_slope(
    ideal_run, u_tau: float
) -> None:
    values = np.concatenate([nominal_values(STANDARD_TERMS), AMPLITUDES])
    free = np.arange(len(values)) >= len(values) - 6
    model = Model.of((*STANDARD_TERMS, thermal_transient(TAU)), values, free)
    motion = whole_motion(ideal_run())
    covariance = np.diag(np.append(np.zeros(6), u_tau**2))
    known = DeterminedModel(model, np.zeros(len(values), bool), covariance, motion)
    change = known.change(known.u * np.eye(7)[6])
    slope = AMPLITUDES * (np.exp(-motion.t / TAU) * motion.t / TAU**2)[:, None]
    bound = 0.4 * np.abs(slope).max(axis=0)  # a difference over half of τ is no derivative
    assert (np.abs(change / u_tau - slope) <= bound + 1e-15).all()
