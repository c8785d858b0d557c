"""The catalogue as columns of the pool: whole, in parts, at times, and courses drawn at random."""

import numpy as np
import pytest
from engine_run import GRAVITY, NOISY, RATE, motion, noise, observed, read

from tasks.explain.explanation import ACCELS, EVERY, GYROS, UNNAMED
from tasks.explain.search.candidates import (
    COSINES,
    OVERSAMPLING,
    STEP_DISTANCE,
    STEP_TIMES,
    STRENGTHS,
    Candidate,
    Prior,
    UnlistedForm,
    Weights,
    behaviours,
    candidates_of,
    columns_of,
    plausible_half_ranges,
    with_proposed_shapes,
)
from tasks.explain.search.design import BandedDesign, banded_design, with_columns
from tasks.explain.search.empirical import empirical, sinusoid
from tasks.explain.search.fitted import with_kinds
from tasks.explain.search.stepwise import Selected, Selection, initial_noises, search
from tasks.model.term import Inputs, Term
from tasks.model.terms import hysteresis as memories
from tasks.model.terms.environment import TEMPERATURE_BIAS, thermal_transient
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.gyro import gyro_dead_band, gyro_scale_nonlinearity
from tasks.model.terms.hysteresis import hysteresis
from tasks.model.terms.memory import BIAS_RANDOM_WALK, bias_step
from tasks.model.terms.site import earth_rotation
from tasks.model.terms.timing import TIME_OFFSET
from tasks.motion.samples import first_order_lag
from tasks.motion.table import EARTH_RATE

# Times of jumps and periods of waves are read off the whitened residual.

RUN = motion()
TERMS: tuple[Term, ...] = (
    bias_step(0, 200.0), bias_step(3, 200.0), TEMPERATURE_BIAS,
    sinusoid(EVERY), sinusoid(GYROS), sinusoid(GYROS), sinusoid(ACCELS),
)  # fmt: skip


def proposed(made: np.ndarray, seed: int) -> tuple[BandedDesign, list[Candidate], list[Candidate]]:
    """The pool after proposals, the candidates before and after."""
    blocks = observed(read(RUN) + made + noise(len(RUN.t), seed, NOISY), RUN)
    listed, columns = candidates_of(TERMS, RUN)
    half = plausible_half_ranges(listed, len(columns))
    pool = banded_design(blocks, blocks.readings, columns, half)
    noises = initial_noises(pool)
    pool, moved = with_proposed_shapes(pool, listed, noises)
    return pool, list(listed), moved


def times(candidates: list[Candidate], channels: set[int], pool: BandedDesign) -> list[float]:
    return [
        one.term.at[0] for one in candidates
        if one.name == "bias_step" and channels == {c for p in one.members for c in pool.columns[p]}
    ]  # fmt: skip


def periods(candidates: list[Candidate], channels: tuple[int, ...]) -> list[float]:
    return [
        one.term.at[0] for one in candidates
        if one.term.parameters == sinusoid(channels).parameters
        and len(one.members) == 2 * len(channels)
    ]  # fmt: skip


@pytest.mark.parametrize(("at", "channel"), [(97.32, 0), (250.04, 2), (310.6, 4)])
def test_the_time_of_a_step_is_found_within_a_block(at: float, channel: int) -> None:
    made = np.zeros((len(RUN.t), 6))
    made[RUN.t >= at, channel] = 8.0 * np.sqrt(NOISY[channel].white)
    pool, _, moved = proposed(made, 1)
    assert abs(times(moved, {channel}, pool)[0] - at) <= 1.0 / RATE + 1e-9
    first = 3 * (channel // 3)
    triad = times(moved, {first, first + 1, first + 2}, pool)
    assert abs(triad[0] - at) <= 1.0 / RATE + 1e-9


def test_two_steps_are_both_proposed_and_not_one_of_them_twice() -> None:
    made = np.zeros((len(RUN.t), 6))
    for at, size in ((120.0, 5.0), (300.0, -8.0)):
        made[RUN.t >= at, 1] += size * np.sqrt(NOISY[1].white)
    pool, _, moved = proposed(made, 2)
    found = np.sort(times(moved, {1}, pool))
    assert np.diff(found).min() >= STEP_DISTANCE
    for at in (120.0, 300.0):
        assert np.abs(found - at).min() < 0.5  # the other step is still in the residual


@pytest.mark.parametrize("period", [2.37, 17.3, 61.0])
def test_the_period_of_a_wave_is_found_within_a_percent(period: float) -> None:
    """Where few go into the run, within a point of the spectrum; the fit takes it from there."""
    made = np.zeros((len(RUN.t), 6))
    made[:, 1] = 0.5 * np.sqrt(NOISY[1].white) * np.sin(2.0 * np.pi * RUN.t / period + 0.4)
    _, _, moved = proposed(made, 3)
    near = max(0.01, period / (OVERSAMPLING * 400.0))
    assert periods(moved, GYROS)[0] == pytest.approx(period, rel=near)
    assert periods(moved, EVERY)[0] == pytest.approx(period, rel=near)
    assert len(set(periods(moved, GYROS))) == 2  # what is tried twice is tried at two periods


def test_what_is_proposed_stands_in_the_pool_and_is_charged_for_the_looking() -> None:
    made = np.zeros((len(RUN.t), 6))
    made[RUN.t >= 150.0, 3] = 5.0 * np.sqrt(NOISY[3].white)
    pool, before, after = proposed(made, 4)
    for old, new in zip(before, after, strict=True):
        assert (new.members, new.own, new.name) == (old.members, old.own, old.name)
        if not new.term.shapes or new.prior is not None:
            assert (new.term, new.shape_trials) == (old.term, old.shape_trials)
            continue
        assert new.shape_trials > 10.0
        fresh = columns_of(new.term, RUN)
        for p, q in zip(new.members, new.own, strict=True):
            for channel, series in fresh[q].items():
                np.testing.assert_array_equal(pool.columns[p][channel], series)


def test_what_was_taken_stays_where_it_is() -> None:
    made = np.zeros((len(RUN.t), 6))
    made[RUN.t >= 150.0, 3] = 5.0 * np.sqrt(NOISY[3].white)
    pool, _, moved = proposed(made, 5)
    held = next(one for one in moved if one.name == "bias_step" and len(one.members) == 3)
    noises = initial_noises(pool)
    pool = with_columns(pool, {}, pool.blocks.readings[::-1].copy())
    for selected in ([held], []):
        _, again = with_proposed_shapes(pool, moved, noises, selected)
        (same,) = [one for one in again if one.key == held.key]
        assert (same.term.at == held.term.at) == bool(selected)


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


# Unlisted forms: what their columns span, what their weights cost, and when they are selected.

TOP = float(np.abs(RUN.rate).max())
LISTED: tuple[Term, ...] = (hysteresis(0.1), gyro_scale_nonlinearity(3, TOP), TEMPERATURE_BIAS)


def columns(name: str, channel: int) -> np.ndarray:
    """(n, k) of an unlisted form in one channel."""
    for term in behaviours(RUN):
        own = [each[channel] for each in term.columns(RUN, Inputs.of(RUN)) if channel in each]
        if term.name == name and own:
            return np.column_stack(own)
    raise AssertionError(name)


def left_of(course: np.ndarray, basis: np.ndarray) -> float:
    """Share of the power of a course (n,) that columns and a constant do not take."""
    basis = np.column_stack([basis, np.ones(len(basis))])
    rest = course - basis @ np.linalg.lstsq(basis, course, rcond=1e-9)[0]
    return float(rest @ rest / ((course - course.mean()) ** 2).sum())


def fast_spin(share: float) -> np.ndarray:
    """(n,) sign of the last turn about x that was faster than a share of the largest rate."""
    state, found = 0.0, np.zeros(len(RUN.t))
    for row, rate in enumerate(RUN.rate[:, 0].tolist()):
        state = float(np.sign(rate)) if abs(rate) > share * TOP else state
        found[row] = state
    return found


def selected(made: np.ndarray) -> Selection:
    """What a search of the listed terms and of every unlisted form selects."""
    readings = made + noise(len(RUN.t), 3, NOISY)
    blocks = observed(readings, RUN)
    tried, own = candidates_of([*LISTED, *behaviours(RUN)], RUN)
    half = plausible_half_ranges(tried, len(own))
    return search(banded_design(blocks, readings, own, half), tried)


@pytest.fixture(scope="module")
def remembered() -> Selection:
    made = read(RUN)
    made[:, 0] += 4e-5 * fast_spin(0.6)
    return selected(made)


def test_columns_are_known_wherever_the_motion_is() -> None:
    for term in behaviours(RUN):
        for column in term.columns(RUN, Inputs.of(RUN)):
            assert all(np.isfinite(signal).all() for signal in column.values())


def test_a_memory_of_the_last_fast_turn_is_among_the_hystereses() -> None:
    assert left_of(fast_spin(0.6), columns("hysteresis", 0)) < 0.05


@pytest.mark.parametrize("bend", [np.abs, lambda x: x**3 - x**5, np.tanh])
def test_a_curve_of_the_own_rate_is_among_the_non_linearities(bend) -> None:
    course = bend(RUN.rate[:, 1] / TOP)
    assert left_of(course, columns("gyro_scale_nonlinearity", 1)) < 5e-3


def test_a_distribution_of_lags_has_any_lag() -> None:
    temperature = RUN.recorded["temperature"] - RUN.recorded["temperature"][0]
    late = first_order_lag(temperature, RUN.interval, 60.0)
    assert left_of(late, columns("temperature_bias", 4)) < 1e-3


def test_weights_have_one_variance_in_the_readings_units() -> None:
    power = np.array([4.0, 1.0, 0.0, 16.0])  # of two channels: the clearest column sets the unit
    precision = Weights(100.0, 2).precision(power)
    np.testing.assert_allclose(precision[:2], [0.01, 0.04])
    assert precision[3] == pytest.approx(0.01)
    assert precision[2] > 1e8


def test_a_memory_of_no_listed_form_is_one_finding_of_its_kind(remembered: Selection) -> None:
    (one,) = remembered.candidates
    assert (one.name, one.unlisted) == ("hysteresis", True)


@pytest.mark.parametrize(("term", "size"), [(LISTED[0], 3e-4), (LISTED[1], 2e-3)])
def test_a_listed_form_keeps_its_place(term: Term, size: float) -> None:
    found = selected(read(RUN, (term, [size, -size, 0.0])))
    assert [(one.name, one.unlisted) for one in found.candidates] == [(term.name, False)]


def test_nothing_is_selected_in_noise() -> None:
    assert not selected(read(RUN)).candidates


def test_an_unlisted_form_is_no_form_of_its_name(remembered: Selection) -> None:
    one: Candidate = remembered.candidates[0]
    assert not one.is_form_of(("hysteresis",))


# Where kinds of behaviour are tried, and which forms and empirical terms stand beside them.

DEAD_BAND = gyro_dead_band(0.05)
(PLAYS, *_) = (one for one in memories._OF_GYROS if one.source == memories.PLAYS)
MEMORY = memories.hysteresis(0.1)
LISTED_KINDS: tuple[Term, ...] = (PLAYS, MEMORY, DEAD_BAND, TEMPERATURE_BIAS, TIME_OFFSET)
FOLLOWS = empirical(RUN)[0]


def tried(
    *selected: Term, nuisance: bool = False, gains: tuple[float, ...] = ()
) -> tuple[Term, ...]:
    """Terms of the second search after a first one selected some."""
    own = [tuple(range(len(term.parameters))) for term in selected]
    found = [
        Selected(Candidate(term, numbers, numbers, 1, nuisance=nuisance), gain, gain)
        for term, numbers, gain in zip(selected, own, gains or len(selected) * (50.0,), strict=True)
    ]
    return with_kinds(LISTED_KINDS, found, RUN)


def kinds(terms: tuple[Term, ...]) -> set[str]:
    return {term.name for term in terms if isinstance(term, UnlistedForm)}


def test_what_has_no_name_may_be_any_kind_of_behaviour() -> None:
    assert {"hysteresis", "gyro_scale_nonlinearity", "vibration_rectification"} < kinds(
        tried(FOLLOWS)
    )


@pytest.mark.parametrize("selected", [(), (MEMORY,), (TEMPERATURE_BIAS,)])
def test_a_listed_form_is_not_questioned(selected: tuple[Term, ...]) -> None:
    assert not tried(*selected)


def test_what_every_model_has_asks_for_no_kind() -> None:
    assert not tried(FOLLOWS, nuisance=True)


def test_a_delay_leaves_what_looks_like_memory_and_is_smaller() -> None:
    assert not tried(FOLLOWS, TIME_OFFSET, gains=(50.0, 2000.0))
    assert tried(FOLLOWS, TIME_OFFSET, gains=(600.0, 5.0))
    assert not tried(TIME_OFFSET, FOLLOWS, gains=(5.0, 600.0), nuisance=True)


def test_a_sum_of_plays_gives_way_to_an_unlisted_hysteresis() -> None:
    terms = tried(PLAYS)
    assert "hysteresis" in kinds(terms)
    assert PLAYS not in terms
    assert MEMORY in terms
    assert DEAD_BAND in terms


@pytest.mark.parametrize(("angle", "questioned"), [(0.1, False), (0.0101, True), (6.0, True)])
def test_a_form_that_is_driven_to_its_end_is_another(angle: float, questioned: bool) -> None:
    terms = tried(memories.hysteresis(angle))
    assert bool(terms) is questioned
    assert MEMORY not in terms


def test_empirical_terms_that_a_kind_has_among_its_forms_do_not_compete_with_it() -> None:
    beside = tried(FOLLOWS)
    left_out = {one.equation for one in empirical(RUN)} - {one.equation for one in beside}
    assert {"reading += c·ω_i²", "reading += c·lag(ω², 7 s)"} < left_out
    assert {"reading += c·|ω_j|", "reading += c·lag(ω, 7 s)", "reading += c·f_j·f_k"} < left_out


def test_other_empirical_terms_compete_with_the_kinds() -> None:
    equations = {one.equation for one in tried(FOLLOWS) if one.name == UNNAMED}
    assert {"reading += c·lag(|f|, 7 s)", "reading += c·ω̇"} < equations
