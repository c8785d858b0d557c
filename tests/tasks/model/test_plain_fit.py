"""The standard's regressors, and their plain fit to whole samples."""

from dataclasses import replace

import numpy as np
import pytest
from model_unit import tumbling

from tasks.model.fit import MAX_FIT_ROWS, plain_prediction
from tasks.model.simulate import predict
from tasks.model.term import nominal_values
from tasks.model.terms.standard import STANDARD_TERMS, regressors

RUN = tumbling(300, seed=4)
VALUES = nominal_values(STANDARD_TERMS) + 1e-3 * np.random.default_rng(4).standard_normal(39)
READINGS = predict(STANDARD_TERMS, RUN, VALUES)


def test_a_gyro_reads_rate_one_and_the_vertical() -> None:
    expected = np.column_stack([RUN.rate, np.ones(len(RUN.t)), RUN.up])
    np.testing.assert_allclose(regressors(RUN, 1), expected, rtol=1e-14)


def test_an_accelerometer_reads_no_square_of_its_own_rate() -> None:
    squares = RUN.rate[:, [0, 2]] ** 2
    expected = np.column_stack([RUN.up, np.ones(len(RUN.t)), squares])
    np.testing.assert_allclose(regressors(RUN, 4), expected, rtol=1e-14)


def test_what_the_standards_model_reads_is_predicted_exactly() -> None:
    np.testing.assert_allclose(plain_prediction(READINGS, RUN), READINGS, atol=1e-10)


def test_masked_readings_do_not_take_part_but_are_predicted() -> None:
    masked = np.zeros(READINGS.shape, bool)
    masked[:40, 2] = True
    spoilt = np.where(masked, READINGS + 5.0, READINGS)
    np.testing.assert_allclose(plain_prediction(spoilt, RUN, masked), READINGS, atol=1e-10)


def test_nothing_is_predicted_where_the_motion_is_not_known_or_nothing_was_read() -> None:
    up = RUN.up.copy()
    up[:10] = np.nan
    silent = READINGS.copy()
    silent[:, 5] = np.nan
    predicted = plain_prediction(silent, replace(RUN, up=up))
    assert np.isnan(predicted[:10]).all()
    assert np.isnan(predicted[:, 5]).all()
    assert np.isfinite(predicted[10:, :5]).all()


def test_a_long_run_is_fitted_to_evenly_spread_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    assert MAX_FIT_ROWS > 1e5
    monkeypatch.setattr("tasks.model.fit.MAX_FIT_ROWS", 100)
    spoilt = READINGS.copy()
    spoilt[1::4] += 5.0  # rows between those that are fitted
    np.testing.assert_allclose(plain_prediction(spoilt, RUN), READINGS, atol=1e-10)
