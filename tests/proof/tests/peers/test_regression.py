"""Algebra on normal equations beside the same with rows."""

import numpy as np
import pytest

from tasks.explain.evidence.cells import FOLDS
from tests.proof.peers.observation import Equations
from tests.proof.peers.regression import fit, partialled_out, surprise

ROWS, BASE, MORE = 400, 3, 4


@pytest.fixture
def rows() -> tuple[np.ndarray, np.ndarray]:
    """Columns with the reading last, (n, BASE + MORE + 1), and folds (n,)."""
    rng = np.random.default_rng(8)
    stack = rng.standard_normal((ROWS, BASE + MORE + 1))
    stack[:, -1] += 2.0 * stack[:, 0] + 0.7 * stack[:, BASE + 1]
    return stack, np.arange(ROWS) // 10 % FOLDS


@pytest.fixture
def equations(rows: tuple[np.ndarray, np.ndarray]) -> Equations:
    stack, fold = rows
    grams = np.array([stack[fold == k].T @ stack[fold == k] for k in range(FOLDS)])
    return Equations(grams, BASE, np.ones(BASE + MORE), tuple("abcd"))


def test_fit_is_least_squares(rows: tuple[np.ndarray, np.ndarray], equations: Equations) -> None:
    which = [0, 1, 2, BASE + 1]
    known, *_ = np.linalg.lstsq(rows[0][:, which], rows[0][:, -1])
    np.testing.assert_allclose(fit(equations.without(None), BASE, [1])[which], known, rtol=1e-9)


def test_what_the_standard_explains_is_partialled_out_of_the_library(
    rows: tuple[np.ndarray, np.ndarray], equations: Equations
) -> None:
    stack = rows[0].copy()
    stack[:, BASE] = stack[:, 0] - stack[:, 1]  # told by the standard's columns whole
    gram = stack.T @ stack
    normal, right, open_ = partialled_out(gram, BASE)
    assert open_.tolist() == [False, True, True, True]
    values, *_ = np.linalg.lstsq(stack[:, :BASE], stack[:, BASE:])
    rest = stack[:, BASE:] - stack[:, :BASE] @ values
    np.testing.assert_allclose(normal, rest[:, :-1].T @ rest[:, :-1], atol=1e-9)
    np.testing.assert_allclose(right, rest[:, :-1].T @ rest[:, -1], atol=1e-9)


def test_surprise_is_that_of_the_predictive_distribution(
    rows: tuple[np.ndarray, np.ndarray], equations: Equations
) -> None:
    stack, fold = rows
    which = [0, 1, 2, BASE + 1]
    own, held = stack[fold != 2], stack[fold == 2]
    normal = own[:, which].T @ own[:, which]
    values = np.linalg.solve(normal, own[:, which].T @ own[:, -1])
    error = held[:, -1] - held[:, which] @ values
    covariance = np.eye(len(held)) + held[:, which] @ np.linalg.solve(normal, held[:, which].T)
    square, whole = surprise(equations, 2, [1])
    assert square == pytest.approx(error @ np.linalg.solve(covariance, error), rel=1e-6)
    assert whole - square == pytest.approx(np.linalg.slogdet(covariance)[1], rel=1e-6)
