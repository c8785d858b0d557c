"""The median by sorting is numpy's."""

import numpy as np
import pytest

from tasks.readings.robust import median


@pytest.mark.parametrize("shape", [(1,), (2,), (5,), (2000,), (6, 416), (3, 7)])
def test_medians_are_those_of_numpy(shape):
    values = np.random.default_rng(1).normal(size=shape)
    assert np.array_equal(median(values), np.median(values, axis=-1))


def test_a_row_with_nan_has_no_median():
    assert np.isnan(median(np.array([[1.0, np.nan, 2.0], [3.0, 1.0, 2.0]]))).tolist() == [
        True,
        False,
    ]
