"""What terms predict, against the models of the standard written out."""

import numpy as np
import pytest
from model_unit import GRAVITY, tumbling

from tasks.model.simulate import linearise, predict
from tasks.model.term import nominal_values, parameters_of
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.site import earth_rotation
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.model.terms.timing import ACCEL_AXIS_SKEW, TIME_OFFSET

MOTION = tumbling()
EARTH = 7.292115e-5


def drawn(terms: tuple, seed: int = 5) -> np.ndarray:
    ranges = np.array([p.plausible for p in parameters_of(terms)])
    return np.random.default_rng(seed).uniform(*(0.1 * ranges.T)) + nominal_values(terms)


def by_hand(values: np.ndarray, rate: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Models (1) and (2), row by row."""
    kg, bg, g = values[:9].reshape(3, 3), values[9:12], values[12:21].reshape(3, 3)
    ka, ba = values[21:30].reshape(3, 3), values[30:33]
    p = np.zeros((3, 3))
    p[~np.eye(3, dtype=bool)] = values[33:39]
    gyro = rate @ kg.T + bg + force @ g.T / GRAVITY
    return np.hstack([gyro, force @ ka.T + ba + rate**2 @ p.T])


def test_the_standard_terms_are_models_1_and_2() -> None:
    values = drawn(STANDARD_TERMS)
    expected = by_hand(values, MOTION.rate, GRAVITY * MOTION.up)
    assert predict(STANDARD_TERMS, MOTION, values) == pytest.approx(expected, abs=1e-12)


def test_an_ideal_unit_reads_what_it_feels() -> None:
    read = predict(STANDARD_TERMS, MOTION, nominal_values(STANDARD_TERMS))
    assert read == pytest.approx(np.hstack([MOTION.rate, GRAVITY * MOTION.up]))


def test_earth_rotation_and_lever_arm_act_before_the_sensor() -> None:
    latitude, r = 0.6, np.array([0.02, -0.05, 0.01])
    terms = (earth_rotation(latitude), LEVER_ARM, *STANDARD_TERMS)
    values = drawn(STANDARD_TERMS)
    earth = EARTH * (np.cos(latitude) * MOTION.north + np.sin(latitude) * MOTION.up)
    rigid = [
        GRAVITY * up + np.cross(a, r) + np.cross(w, np.cross(w, r))
        for up, a, w in zip(MOTION.up, MOTION.acceleration, MOTION.rate, strict=True)
    ]
    # p follows what the gyros feel: ω with Earth's rotation in it.
    expected = by_hand(values, MOTION.rate + earth, np.array(rigid))
    read = predict(terms, MOTION, np.concatenate([r, values]))
    assert read[:, 3:] == pytest.approx(expected[:, 3:], abs=1e-10)
    assert read[:, :3] == pytest.approx(expected[:, :3], abs=1e-12)


def test_every_column_is_the_difference_it_makes() -> None:
    terms = (LEVER_ARM, *STANDARD_TERMS)
    values = drawn(terms)
    design = linearise(terms, MOTION, values)
    for p, column in enumerate(design.columns):
        moved = values.copy()
        moved[p] += 1e-4
        change = (predict(terms, MOTION, moved) - design.prediction) / 1e-4
        stated = np.zeros_like(change)
        for channel, read in column.items():
            stated[:, channel] = read
        assert change == pytest.approx(stated, rel=1e-6, abs=1e-4)


def test_every_column_of_a_sensor_goes_through_the_delays_behind_it() -> None:
    terms = (*STANDARD_TERMS, ACCEL_AXIS_SKEW, TIME_OFFSET)
    values = drawn(terms)
    design = linearise(terms, MOTION, values)
    ahead = linearise(STANDARD_TERMS, MOTION, values[:-2])
    for before, behind in zip(ahead.columns, design.columns, strict=False):
        assert sorted(before) == sorted(behind)
        read = np.zeros((len(MOTION.t), 6))
        for channel, series in before.items():
            read[:, channel] = series
        for term, value in zip(terms[-2:], values[-2:], strict=True):
            read = term.passed(MOTION, read, np.array([value]))
        for channel, series in behind.items():
            assert series == pytest.approx(read[:, channel], abs=1e-12)


def test_where_north_is_unknown_only_the_vertical_part_of_earth_rotation_is_added() -> None:
    from dataclasses import replace

    blind = replace(MOTION, north=np.full_like(MOTION.north, np.nan))
    terms = (earth_rotation(0.6), *STANDARD_TERMS)
    ideal = nominal_values(terms)
    added = (predict(terms, blind, ideal) - predict(STANDARD_TERMS, blind, ideal))[:, :3]
    assert added == pytest.approx(EARTH * np.sin(0.6) * MOTION.up, abs=1e-15)
