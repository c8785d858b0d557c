"""The catalogue as columns of the pool: whole, in parts, at times, and courses drawn at random."""

import numpy as np
import pytest
from engine_run import GRAVITY, motion, read

from tasks.explain.search.candidates import (
    COSINES,
    STEP_TIMES,
    STRENGTHS,
    Prior,
    candidates_of,
    columns_of,
    plausible_half_ranges,
)
from tasks.model.term import Term
from tasks.model.terms.environment import TEMPERATURE_BIAS, thermal_transient
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.memory import BIAS_RANDOM_WALK, bias_step
from tasks.model.terms.site import earth_rotation
from tasks.model.terms.timing import TIME_OFFSET
from tasks.motion.table import EARTH_RATE

RUN = motion()
EARTH = earth_rotation(np.radians(40.0))


def test_a_lever_arm_is_read_by_the_accelerometers_with_one_parameter_for_each_component() -> None:
    columns = columns_of(LEVER_ARM, RUN)
    arm = np.array([0.01, -0.02, 0.03])
    added = np.cross(RUN.acceleration, arm) + np.cross(RUN.rate, np.cross(RUN.rate, arm))
    text = np.zeros((len(RUN.t), 6))
    for value, column in zip(arm, columns, strict=True):
        assert set(column) <= {3, 4, 5}
        for channel, series in column.items():
            text[:, channel] += value * series
    np.testing.assert_allclose(text[:, 3:], added, atol=1e-9 * GRAVITY)


@pytest.mark.parametrize("term", [LEVER_ARM, TEMPERATURE_BIAS, TIME_OFFSET])
def test_columns_times_values_are_what_the_term_does_to_readings(term: Term) -> None:
    size = 1e-4 * term.parameters[0].plausible[1]
    values = size * np.linspace(1.0, 2.0, len(term.parameters))
    done = read(RUN, (term, values)) - read(RUN)
    text = np.zeros_like(done)
    for value, column in zip(values, columns_of(term, RUN), strict=True):
        for channel, series in column.items():
            text[:, channel] += value * series
    np.testing.assert_allclose(text, done, atol=2e-3 * np.abs(done).max())


def test_known_physics_is_one_column_of_its_own_size() -> None:
    (column,) = columns_of(EARTH, RUN)
    assert set(column) == {0, 1, 2}
    whole = np.column_stack([column[c] for c in range(3)])
    np.testing.assert_allclose(np.linalg.norm(whole, axis=1), EARTH_RATE, rtol=1e-6)
    one = candidates_of([EARTH, BIAS_RANDOM_WALK], RUN)[0][0]
    assert one.known
    assert len(one.members) == 1


def test_what_each_channel_reads_for_itself_is_tried_whole_by_triad_and_by_channel() -> None:
    listed, columns = candidates_of([TEMPERATURE_BIAS, BIAS_RANDOM_WALK], RUN)
    parts = [one.own for one in listed if one.name == "temperature_bias"]
    assert parts == [(0, 1, 2, 3, 4, 5), (0, 1, 2), (3, 4, 5), *((c,) for c in range(6))]
    assert {one.trials for one in listed if one.name == "temperature_bias"} == {9}
    for one in listed:
        assert all(p < len(columns) for p in one.members)


def test_what_channels_share_is_not_taken_apart() -> None:
    listed, _ = candidates_of([LEVER_ARM, TIME_OFFSET, BIAS_RANDOM_WALK], RUN)
    assert [one.own for one in listed if one.prior is None] == [(0, 1, 2), (0,)]


def test_a_jump_is_tried_at_several_times_over_the_run() -> None:
    listed, _ = candidates_of([bias_step(0, 1.0), BIAS_RANDOM_WALK], RUN)
    times = [one.term.at[0] for one in listed if one.name == "bias_step"]
    assert len(set(times)) == STEP_TIMES
    assert 0.0 < min(times) < max(times) < RUN.t[-1]
    assert {one.trials for one in listed if one.name == "bias_step"} == {4 * STEP_TIMES}


def test_random_courses_share_their_columns() -> None:
    listed, columns = candidates_of([BIAS_RANDOM_WALK, TEMPERATURE_BIAS], RUN)
    courses = [one for one in listed if one.prior is not None]
    assert {one.name for one in courses} == {"bias_random_walk", "unnamed"}
    # four forms of biases and three of scale factors: all, two triads, six channels
    assert len(courses) == 7 * len(STRENGTHS) * 9
    assert len(columns) == 6 + 2 * 6 * COSINES
    each = len(STRENGTHS) * 9
    assert {(one.name, one.trials) for one in courses} == {
        ("bias_random_walk", each),
        ("unnamed", 6 * each),
    }


def test_the_plausible_range_is_known_beforehand_but_not_that_of_random_courses() -> None:
    listed, columns = candidates_of([LEVER_ARM, thermal_transient(50.0), EARTH], RUN)
    half = plausible_half_ranges(listed, len(columns))
    assert half[:3].tolist() == [0.3, 0.3, 0.3]
    for q in range(6):
        assert half[3 + q] == thermal_transient(50.0).parameters[q].plausible[1]
    assert np.isinf(half[9:]).all()


def test_the_waves_of_a_random_course_fade_with_their_number() -> None:
    power = np.full(2 * COSINES, 7.0)
    precision = Prior(power=2.0, strength=30.0).precision(power).reshape(2, COSINES)
    k = np.arange(1.0, COSINES + 1.0)
    np.testing.assert_allclose(precision[0], precision[1])
    np.testing.assert_allclose(precision[0] / precision[0, 0], k**2)
    assert precision[0, 3] == pytest.approx(1.0 / 30.0)  # the fourth wave has the strength
