"""Uncertainties that hold where residuals hang together and are not alike everywhere."""

import numpy as np
import pytest

from tasks.explain.evidence.scatter import CellInfluence, cell_influence

CELLS, ROWS = 40, 60
SLOPE = 2.0


def influence(
    rng: np.random.Generator, wander: float, uneven: float
) -> tuple[CellInfluence, float]:
    """A slope and an offset in rows of unit noise, to which each cell adds an offset and a slope
    of its own (wander), the more the larger the regressor is there (uneven).
    """
    normal, right = np.zeros((CELLS, 2, 2)), np.zeros((CELLS, 2))
    for cell in range(CELLS):
        size = 0.3 + 2.0 * rng.random()
        x = size * rng.standard_normal(ROWS)
        columns = np.column_stack([np.ones(ROWS), x])
        off = columns @ rng.standard_normal(2) * wander * (1.0 + uneven * size)
        reading = SLOPE * x + off + rng.standard_normal(ROWS)
        normal[cell], right[cell] = columns.T @ columns, columns.T @ reading
    found, change = cell_influence(normal, right, [1], np.zeros(2), np.zeros(2))
    return found, float(change[0])


@pytest.mark.parametrize(("wander", "uneven"), [(0.0, 0.0), (0.5, 0.0), (0.5, 1.0)])
def test_intervals_hold_the_truth_as_often_as_stated(wander: float, uneven: float) -> None:
    rng = np.random.default_rng(7)
    inside = []
    for _ in range(300):
        found, slope = influence(rng, wander, uneven)
        u = np.sqrt(found.covariance[0, 0] * found.dispersion)
        inside.append(abs(slope - SLOPE) < 2.0 * u)
    assert 0.90 < np.mean(inside) < 0.99


def test_where_only_noise_is_left_nothing_is_widened() -> None:
    rng = np.random.default_rng(8)
    widened = [influence(rng, 0.0, 0.0)[0].dispersion > 1.0 for _ in range(200)]
    assert np.mean(widened) < 0.02


def test_what_hangs_together_in_cells_counts_by_cells() -> None:
    """Offsets of 1 and slopes of 1 in cells of 60 rows: nearly sixty times the white variance."""
    found, _ = influence(np.random.default_rng(9), 1.0, 0.0)
    assert 20.0 < found.dispersion < 200.0
    assert found.degrees == pytest.approx(found.effective_cells.sum())
    assert 10.0 < found.degrees < CELLS


def test_columns_that_are_projected_out_do_not_matter() -> None:
    """Neither scatter nor covariance change where the other column is another mix of both."""
    rng = np.random.default_rng(10)
    normal = np.array([(lambda a: a.T @ a)(rng.standard_normal((ROWS, 2))) for _ in range(CELLS)])
    right = rng.standard_normal((CELLS, 2)) * 10.0
    mixed = np.array([[1.0, 0.7], [0.0, 1.0]])  # new columns: c0, c0·0.7 + c1
    first, slope = cell_influence(normal, right, [1], np.zeros(2), np.zeros(2))
    turned = np.linalg.inv(mixed)
    other, same = cell_influence(
        turned.T @ normal @ turned, right @ turned, [1], np.zeros(2), np.zeros(2)
    )
    assert same == pytest.approx(slope, rel=1e-6)
    assert other.robust_covariance == pytest.approx(first.robust_covariance, rel=1e-6)
