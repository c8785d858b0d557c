"""Lists of terms fitted, exact without noise and honest with it; the noise of sums of rows."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from schemas.base import Unusable
from tasks.model.fit import MAX_FIT_ROWS, fit, plain_prediction
from tasks.model.model import predict
from tasks.model.noise import RowNoise
from tasks.model.term import Inputs, Parameter, Term, nominal_values, parameters_of
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.site import earth_rotation
from tasks.model.terms.standard import GYRO_TERMS, STANDARD_TERMS, regressors
from tasks.motion.whole import Motion
from tasks.segments.summarise import SegmentMean
from tasks.uncertainty.drift import DRIFTS, TREND, WALK, drift_shapes
from tests.tasks.model.model_unit import flicker, tumbling

# Lists of terms fitted: exact without noise, honest with it.

WITH_SITE = (earth_rotation(0.7), LEVER_ARM, *STANDARD_TERMS)


def quiet(motion: Motion, deviation: float = 1e-3) -> RowNoise:
    count = len(motion.t)
    return RowNoise(motion.t, np.full((count, 6), deviation**2), np.zeros((DRIFTS, 6)))


def drawn(terms: tuple[Term, ...], seed: int) -> np.ndarray:
    ranges = np.array([p.plausible for p in parameters_of(terms)])
    return np.random.default_rng(seed).uniform(*(0.2 * ranges.T)) + 0.8 * nominal_values(terms)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10_000))
def test_what_was_put_in_comes_out_without_noise(seed):
    motion, values = tumbling(seed=seed), drawn(WITH_SITE, seed)
    found = fit(WITH_SITE, motion, predict(WITH_SITE, motion, values), quiet(motion))
    assert found.estimable.all()
    assert found.values == pytest.approx(values, abs=1e-8)
    assert found.chi2 < 1e-6


def test_the_truth_lies_within_the_stated_uncertainty_in_white_and_flicker_noise():
    rng = np.random.default_rng(8)
    motion = tumbling(400, seed=8)
    h, deviation, values = 4e-7, 1e-3, drawn(STANDARD_TERMS, 8)
    drift = np.zeros((DRIFTS, 6))
    drift[WALK - 1] = h  # the flicker that reaches lowest
    noise = replace(quiet(motion, deviation), drift=drift)
    clean = predict(STANDARD_TERMS, motion, values)
    z = []
    for _ in range(60):
        shaken = np.column_stack([flicker(400, 1.0, h, rng) for _ in range(6)])
        shaken += deviation * rng.standard_normal(shaken.shape)
        found = fit(STANDARD_TERMS, motion, clean + shaken, noise)
        z.append((found.values - values) / found.u)
    assert np.sqrt(np.mean(np.square(z))) == pytest.approx(1.0, abs=0.06)
    white = fit(STANDARD_TERMS, motion, clean, quiet(motion, deviation))
    assert np.median(found.u / white.u) > 1.1  # the flicker counts


def test_chi_square_is_the_number_of_degrees_of_freedom():
    motion, values = tumbling(2000, seed=3), drawn(STANDARD_TERMS, 3)
    readings = predict(STANDARD_TERMS, motion, values)
    readings += 1e-3 * np.random.default_rng(3).standard_normal(readings.shape)
    found = fit(STANDARD_TERMS, motion, readings, quiet(motion))
    assert found.degrees == 6 * 2000 - 39
    assert found.chi2 / found.degrees == pytest.approx(1.0, abs=0.05)
    assert np.nanstd(found.residuals) == pytest.approx(1e-3, rel=0.02)


def test_what_the_rows_do_not_determine_is_not_given():
    motion = tumbling(seed=2)
    level = replace(motion, up=np.tile([0.0, 0.0, 1.0], (len(motion.t), 1)))
    readings = predict(STANDARD_TERMS, level, nominal_values(STANDARD_TERMS))
    found = fit(STANDARD_TERMS, level, readings, quiet(level))
    given_ = {p.symbol for p, v in zip(found.parameters, found.values, strict=True) if v == v}
    assert {"K_gxy", "p_zx"} <= given_
    assert not {"B_gx", "g_xz", "g_xx", "K_axx", "K_azz", "B_az"} & given_


def test_rows_that_are_missing_or_unknown_are_left_out():
    motion, values = tumbling(seed=6), drawn(STANDARD_TERMS, 6)
    readings = predict(STANDARD_TERMS, motion, values)
    readings[:50, :3] = np.nan
    rate = motion.rate.copy()
    rate[100:130] = np.nan
    unknown = replace(motion, rate=rate)
    found = fit(STANDARD_TERMS, unknown, readings, quiet(motion))
    assert found.values == pytest.approx(values, abs=1e-8)
    assert np.isnan(found.residuals[:50, :3]).all()
    assert np.isnan(found.residuals[100:130]).all()
    assert np.isfinite(found.residuals[:50, 3:]).all()


@dataclass(frozen=True)
class BiasByTime(Term):
    """A term that nobody knows yet: a bias of one gyro that grows with time."""

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[dict[int, np.ndarray], ...]:
        return ({1: motion.t},)


CREEP = BiasByTime(
    "creep", "memory", "sensor", "ω′_y = c·t", "this test",
    (Parameter("c", "c", "rad/s2", "rad/s2", (-1e-3, 1e-3)),),
)  # fmt: skip


def test_a_new_term_is_fitted_without_touching_anything_else():
    motion = tumbling(seed=7)
    terms = (*GYRO_TERMS, CREEP)
    values = np.append(drawn(GYRO_TERMS, 7), 2e-4)
    found = fit(terms, motion, predict(terms, motion, values), quiet(motion))
    assert found.values == pytest.approx(values, abs=1e-9)


@dataclass(frozen=True)
class Runaway(Term):
    """A cube root, from whose zero every step of Newton's leads away."""

    def felt(self, motion: Motion, inputs: Inputs, values: np.ndarray) -> Inputs:
        return Inputs(inputs.rate + np.cbrt(values[0]), inputs.force)


def test_a_fit_that_does_not_settle_is_refused_with_its_terms():
    motion = tumbling(seed=9)
    runaway = Runaway(
        "runaway",
        "site",
        "input",
        "∛x",
        "this test",
        (Parameter("x", "x", "1", "1", (-1, 1), 0.5),),
    )
    ideal = predict(STANDARD_TERMS, motion, nominal_values(STANDARD_TERMS))
    with pytest.raises(Unusable, match="the fit of runaway, gyro_matrix did not settle"):
        fit((runaway, GYRO_TERMS[0]), motion, ideal, quiet(motion))


# The standard's regressors, and their plain fit to whole samples.

RUN = tumbling(300, seed=4)
VALUES = nominal_values(STANDARD_TERMS) + 1e-3 * np.random.default_rng(4).standard_normal(39)
READINGS = predict(STANDARD_TERMS, RUN, VALUES)


def test_an_accelerometer_reads_no_square_of_its_own_rate():
    squares = RUN.rate[:, [0, 2]] ** 2
    expected = np.column_stack([RUN.up, np.ones(len(RUN.t)), squares])
    np.testing.assert_allclose(regressors(RUN, 4), expected, rtol=1e-14)


def test_masked_readings_do_not_take_part_but_are_predicted():
    masked = np.zeros(READINGS.shape, bool)
    masked[:40, 2] = True
    spoilt = np.where(masked, READINGS + 5.0, READINGS)
    np.testing.assert_allclose(plain_prediction(spoilt, RUN, masked), READINGS, atol=1e-10)


def test_nothing_is_predicted_where_the_motion_is_not_known_or_nothing_was_read():
    up = RUN.up.copy()
    up[:10] = np.nan
    silent = READINGS.copy()
    silent[:, 5] = np.nan
    predicted = plain_prediction(silent, replace(RUN, up=up))
    assert np.isnan(predicted[:10]).all()
    assert np.isnan(predicted[:, 5]).all()
    assert np.isfinite(predicted[10:, :5]).all()


def test_a_long_run_is_fitted_to_evenly_spread_rows(monkeypatch):
    assert MAX_FIT_ROWS > 1e5
    monkeypatch.setattr("tasks.model.fit.MAX_FIT_ROWS", 100)
    spoilt = READINGS.copy()
    spoilt[1::4] += 5.0  # rows between those that are fitted
    np.testing.assert_allclose(plain_prediction(spoilt, RUN), READINGS, atol=1e-10)


# The covariance of weighted sums, against the closed formulas and against drawn noise.

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
