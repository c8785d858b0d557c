"""Small matrices at once, beside LAPACK on each."""

import numpy as np
import pytest

from tasks.review.windows import inverses, quadratic_forms


def _matrices(size: int) -> np.ndarray:
    columns = np.random.default_rng(size).standard_normal((40, 2 * size, size))
    return np.einsum("nki,nkj->nij", columns, columns) + 0.1 * np.eye(size)


@pytest.mark.parametrize("size", [1, 3, 6])
def test_inverses_and_determinants_are_those_of_lapack(size):
    matrices = _matrices(size)
    found, logarithm = inverses(matrices)
    np.testing.assert_allclose(found, np.linalg.inv(matrices), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(logarithm, np.linalg.slogdet(matrices)[1], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("size", [1, 3, 6])
def test_quadratic_forms_are_those_of_the_solutions(size):
    matrices, right = _matrices(size), np.random.default_rng(2).standard_normal((40, size))
    solved = np.linalg.solve(matrices, right[:, :, None])[:, :, 0]
    np.testing.assert_allclose(
        quadratic_forms(matrices, right), (right * solved).sum(axis=1), rtol=1e-9
    )
