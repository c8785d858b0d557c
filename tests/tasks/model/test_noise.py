"""The covariance of weighted sums, against the closed formulas and against drawn noise."""

import numpy as np
import pytest

from tasks.model.noise import RowNoise
from tasks.segments.summarise import SegmentMean
from tasks.uncertainty.drift import DRIFTS, TREND, WALK, drift_shapes
from tests.tasks.model.model_unit import flicker

COUNT = 300
T = np.arange(COUNT) * 0.5


def noise(flicker: float = 0.0, walk: float = 0.0, trend: float = 0.0) -> RowNoise:
    drift = np.zeros((DRIFTS, 6))
    drift[[WALK - 1, WALK, TREND]] = np.array([[flicker], [walk], [trend]])
    return RowNoise(T, np.zeros((COUNT, 6)), drift)


def rows_as_segments() -> tuple[SegmentMean, ...]:
    """Each row as a segment of its own length."""

    class Row:
        def __init__(self, t: float) -> None:
            self.t_start, self.t_end = t - 0.25, t + 0.25

    return tuple(Row(t) for t in T)  # type: ignore[arg-type, misc]


@pytest.mark.parametrize("which", range(3))
def test_the_sums_have_the_covariance_of_the_closed_formulas(which):
    strength = [0.0, 0.0, 0.0]
    strength[which] = 2.0
    columns = np.random.default_rng(1).standard_normal((COUNT, 3)) + np.array([0.0, 1.0, 5.0])
    dense = 2.0 * columns.T @ drift_shapes(rows_as_segments())[WALK - 1 + which] @ columns
    found = noise(*strength).gram(2, columns)
    scale = np.sqrt(np.outer(np.diag(dense), np.diag(dense)))
    assert found / scale == pytest.approx(dense / scale, abs=0.02)


def test_white_noise_is_each_rows_own():
    white = np.random.default_rng(2).uniform(1.0, 4.0, (COUNT, 6))
    columns = np.random.default_rng(3).standard_normal((COUNT, 2))
    own = RowNoise(T, white, np.zeros((DRIFTS, 6)))
    assert own.gram(4, columns) == pytest.approx(columns.T @ np.diag(white[:, 4]) @ columns)


def test_drawn_flicker_scatters_as_stated():
    rng = np.random.default_rng(4)
    column = np.where(np.arange(COUNT) % 60 < 30, 1.0, -1.0)[:, None]
    sums = [float(flicker(COUNT, 0.5, 3.0, rng) @ column[:, 0]) for _ in range(400)]
    stated = float(noise(flicker=3.0).gram(0, column)[0, 0])
    assert np.var(sums) == pytest.approx(stated, rel=0.2)
