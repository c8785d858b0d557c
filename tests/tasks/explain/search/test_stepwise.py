"""What the search charges, gains and takes: held to least squares and to Gauss's formula."""

from collections.abc import Sequence
from dataclasses import replace
from random import Random
from typing import NamedTuple

import numpy as np
import pytest
from engine_run import NOISY, QUIET, chi2, motion, noise, observed, read, whitened
from hypothesis import given, settings
from hypothesis import strategies as st
from labelled_rests import labelled_rests, recording_of

from schemas.recording import Recording
from tasks.explain.explain import explain
from tasks.explain.explanation import CERTAIN, GYROS
from tasks.explain.inputs.blocks import Blocks
from tasks.explain.search.candidates import (
    COSINES,
    STRENGTHS,
    Candidate,
    candidates_of,
    columns_of,
    plausible_half_ranges,
)
from tasks.explain.search.design import (
    BandedDesign,
    NormalEquations,
    banded_design,
    normal_equations,
)
from tasks.explain.search.empirical import sinusoid
from tasks.explain.search.stepwise import (
    FALSE_ALARMS,
    PER_PARAMETER,
    Selection,
    departure_shown,
    places_apart,
    rank,
    search,
    with_rivals,
)
from tasks.model.term import Column, Term
from tasks.model.terms.electronics import BANDWIDTH
from tasks.model.terms.environment import TEMPERATURE_BIAS, THERMAL_GRADIENT, thermal_transient
from tasks.model.terms.geometry import LEVER_ARM, SIZE_EFFECT
from tasks.model.terms.memory import BIAS_RANDOM_WALK
from tasks.model.terms.site import GRAVITY_VALUE, earth_rotation
from tasks.model.terms.standard import regressors
from tasks.model.terms.timing import TIME_OFFSET
from tasks.motion.whole import Motion

RUN = motion()
EARTH = earth_rotation(np.radians(40.0))
TERMS: tuple[Term, ...] = (
    EARTH, GRAVITY_VALUE, LEVER_ARM, SIZE_EFFECT, TIME_OFFSET, TEMPERATURE_BIAS, THERMAL_GRADIENT,
    thermal_transient(60.0), BIAS_RANDOM_WALK,
)  # fmt: skip
ARM = (0.004, -0.006, 0.003)
WARMING = (4e-6, 0.0, -3e-6, 0.0, 1e-4, 0.0)


class Asked(NamedTuple):
    blocks: Blocks
    pool: BandedDesign
    candidates: tuple[Candidate, ...]
    columns: tuple[Column, ...]

    def named(self, name: str) -> Candidate:
        return next(one for one in self.candidates if one.name == name)


def asked(readings: np.ndarray, terms: Sequence[Term] = TERMS) -> Asked:
    blocks = observed(readings, RUN)
    listed, columns = candidates_of(terms, RUN)
    half = plausible_half_ranges(listed, len(columns))
    return Asked(blocks, banded_design(blocks, readings, columns, half), listed, columns)


@pytest.fixture(scope="module")
def both() -> Asked:
    """A lever arm and a bias that warms, in noise that drifts."""
    made = read(RUN, (LEVER_ARM, ARM), (TEMPERATURE_BIAS, WARMING))
    return asked(made + noise(len(RUN.t), 5, NOISY))


@pytest.fixture(scope="module")
def found_in_both(both: Asked) -> Selection:
    return search(both.pool, both.candidates)


@pytest.fixture(scope="module")
def nothing() -> Asked:
    return asked(read(RUN) + noise(len(RUN.t), 6, NOISY))


def misfit(one: Asked, columns: Sequence[int] = (), without: np.ndarray | None = None) -> float:
    readings = one.blocks.readings if without is None else one.blocks.readings - without
    return chi2(one.pool, readings, [one.columns[p] for p in columns], NOISY)[0]


@pytest.mark.parametrize(
    ("name", "beside"),
    [
        ("lever_arm", None), ("temperature_bias", None), ("time_offset", None),
        ("temperature_bias", "lever_arm"), ("temperature_bias", "thermal_gradient"),
        ("size_effect", "time_offset"),
    ],
)  # fmt: skip
def test_a_gain_is_the_difference_of_two_fits(both: Asked, name: str, beside: str | None) -> None:
    taken = [] if beside is None else [both.named(beside)]
    held = [p for one in taken for p in one.members]
    one = both.named(name)
    state = normal_equations(both.pool, NOISY)
    own = next(s for s in rank(state, both.candidates, taken) if s.candidate is one)
    direct = misfit(both, held) - misfit(both, [*held, *one.members])
    assert own.gain == pytest.approx(direct, rel=2e-3, abs=0.3)
    count = int((state.scale[list(one.members)] > 0).sum())
    # Of nine places three look like the standard's p_ij: they are not charged.
    assert count == {"size_effect": 6}.get(name, len(one.members))
    price = PER_PARAMETER * count + 2.0 * np.log(one.trials) + one.term.rarity
    assert own.gain - own.score == pytest.approx(price)


def test_known_physics_is_compared_by_its_own_size_and_wins_over_what_fits_no_better() -> None:
    for strength in (0.0, 1.0, 3.0):
        (effect,) = columns_of(EARTH, RUN)
        made = read(RUN) + noise(len(RUN.t), 7, NOISY)
        for channel, series in effect.items():
            made[:, channel] += strength * series
        one = asked(made)
        known = one.named("earth_rotation")
        ranked = rank(normal_equations(one.pool, NOISY), one.candidates, ())
        own = next(scored for scored in ranked if scored.candidate is known)
        taken_off = np.zeros_like(made)
        for channel, series in effect.items():
            taken_off[:, channel] = series
        direct = misfit(one) - misfit(one, (), taken_off)
        assert own.gain == pytest.approx(direct, rel=2e-3, abs=0.3)
        ahead = CERTAIN if own.gain > 2.0 * CERTAIN else 0.0
        assert own.score == pytest.approx(own.gain - EARTH.rarity + ahead)
        # Where Earth's rate is absent, or is three times as large, taking it off once is no fit.
        assert (own.gain > 0) == (strength > 0.5)


@pytest.mark.parametrize("channel", [0, 4])
def test_the_evidence_of_a_random_course_is_that_of_gausss_formula(channel: int) -> None:
    run = RUN.taken(np.arange(0, len(RUN.t), 25))
    rng = np.random.default_rng(8)
    walk = (
        np.cumsum(rng.standard_normal((len(run.t), 6)), axis=0)
        * 0.3
        * np.sqrt([each.white for each in QUIET])
    )
    made = read(run) + noise(len(run.t), 8, QUIET, 1.0) + walk
    blocks = observed(made, run, 1.0)
    listed, columns = candidates_of([BIAS_RANDOM_WALK], run)
    pool = banded_design(blocks, made, columns, plausible_half_ranges(listed, len(columns)))
    state = normal_equations(pool, QUIET)
    ranked = rank(state, listed, ())
    some = [one for one in ranked if one.candidate.prior is not None]
    some = [one for one in some if one.candidate.own[0] == COSINES * channel]
    some = [one for one in some if len(one.candidate.members) == COSINES]
    assert len(some) == (4 + 3) * len(STRENGTHS)  # of biases and of scale factors
    for scored in some:
        one = scored.candidate
        design = whitened(regressors(run, channel).T, pool, channel, QUIET[channel])
        series = whitened([columns[p][channel] for p in one.members], pool, channel, QUIET[channel])
        target = whitened([made[:, channel]], pool, channel, QUIET[channel])
        outside = np.eye(len(design)) - design @ np.linalg.pinv(design, rcond=1e-10)
        series, left = outside @ series, (outside @ target)[:, 0]
        power = (series**2).sum(axis=0)
        assert one.prior is not None
        variance = 1.0 / (one.prior.precision(power) * power)  # of each wave's factor
        spread = np.eye(len(left)) + (series * variance) @ series.T
        likelier = left @ left - left @ np.linalg.solve(spread, left) - np.linalg.slogdet(spread)[1]
        assert scored.gain == pytest.approx(likelier, rel=1e-3, abs=0.05)


@pytest.mark.parametrize("of_scale", [True, False])
def test_scale_factors_that_wander_and_biases_that_do_are_told_apart(of_scale: bool) -> None:
    steps = np.random.default_rng(9).standard_normal(len(RUN.t))
    walk = np.cumsum(np.cumsum(steps - steps.mean()))
    made = read(RUN) + noise(len(RUN.t), 9, NOISY)
    made[:, 2] += 0.05 * walk / np.abs(walk).max() * (RUN.rate[:, 2] if of_scale else 0.02)
    one = asked(made)
    first = rank(normal_equations(one.pool, NOISY), one.candidates, ())[0].candidate
    assert first.prior is not None
    assert ("input" in first.term.equation) == of_scale


def test_what_was_planted_is_found_and_nothing_else(found_in_both: Selection) -> None:
    found = found_in_both
    assert found.p_value < 1e-9
    assert {one.candidate.name for one in found.selected} == {"lever_arm", "temperature_bias"}
    gains = [one.gain for one in found.selected]
    assert gains == sorted(gains, reverse=True)


def test_where_nothing_is_missing_nothing_is_found(nothing: Asked) -> None:
    found = search(nothing.pool, nothing.candidates)
    assert found.selected == ()
    assert found.p_value > FALSE_ALARMS


def test_what_is_significant_and_yet_too_rare_ends_the_search(both: Asked) -> None:
    rare = tuple(
        replace(one, term=replace(one.term, rarity=1e6))
        for one in both.candidates
        if one.name == "lever_arm"
    )
    found = search(both.pool, rare)
    assert found.p_value < FALSE_ALARMS
    assert found.selected == ()


def test_a_wrong_start_is_exchanged_for_what_does_better(both: Asked) -> None:
    wrong = both.named("thermal_gradient")
    found = search(both.pool, both.candidates, [wrong])
    assert {one.candidate.name for one in found.selected} == {"lever_arm", "temperature_bias"}


@pytest.mark.rehearsal
@settings(max_examples=4, deadline=None)
@given(st.randoms(use_true_random=False))
def test_the_order_of_the_candidates_does_not_matter(
    both: Asked, found_in_both: Selection, random: Random
) -> None:
    mixed = list(both.candidates)
    random.shuffle(mixed)
    first, second = found_in_both, search(both.pool, mixed)
    assert [one.candidate for one in first.selected] == [one.candidate for one in second.selected]
    for one, two in zip(first.selected, second.selected, strict=True):
        assert one.gain == pytest.approx(two.gain, rel=1e-6)


def test_a_time_constant_that_would_be_negative_finds_nothing() -> None:
    """Stamps that are early look like a low-pass of negative time constant; none is."""
    made = read(RUN, (TIME_OFFSET, (-0.004,)))
    one = asked(made + noise(len(RUN.t), 7, NOISY), (BANDWIDTH, TIME_OFFSET))
    early = search(one.pool, one.candidates, (), NOISY)
    assert [each.candidate.name for each in early.selected] == ["time_offset"]


# A lever arm stands alone where the accelerometers, were they apart, would have shown it.

NOISE = noise(len(RUN.t), 3, NOISY)
ARM_SPECIAL_CASE = np.array([0.0004, -0.0006, 0.00023])  # small: the noise is told beside it


def shown(run: Motion, own: tuple[int, ...] = tuple(range(9))) -> float:
    """own: the places that are among the columns, in the order of the term's parameters."""
    made = read(run, (LEVER_ARM, ARM_SPECIAL_CASE)) + NOISE
    blocks = observed(made, run)
    of_places = columns_of(SIZE_EFFECT, run)
    columns = [*columns_of(LEVER_ARM, run), *(of_places[k] for k in own)]
    arm = Candidate(LEVER_ARM, (0, 1, 2), (0, 1, 2), 1)
    places = Candidate(SIZE_EFFECT, tuple(range(3, 3 + len(own))), own, 1)
    design = banded_design(blocks, made, columns, np.full(len(columns), np.inf))
    equations = search(design, [arm, places], (), NOISY).equations
    return departure_shown(equations, places, (), ARM_SPECIAL_CASE)


def left_by_a_lever_arm(places: np.ndarray) -> float:
    """Chi-squared of the noise, and of places of their own, that a lever arm and the standard
    leave.
    """
    made = read(RUN, (SIZE_EFFECT, places)) + NOISE
    design = banded_design(observed(made, RUN), made, [*columns_of(LEVER_ARM, RUN)],
                           np.full(3, np.inf))  # fmt: skip
    arm = Candidate(LEVER_ARM, (0, 1, 2), (0, 1, 2), 1)
    equations = search(design, [arm], (), NOISY).equations
    made_up = equations.right @ np.linalg.pinv(equations.normal) @ equations.right
    return float(equations.misfit - made_up)


def test_places_apart_have_the_lever_arm_for_their_mean_and_its_size_for_their_spread() -> None:
    places = places_apart(ARM_SPECIAL_CASE).reshape(3, 3)
    assert places.mean(axis=0) == pytest.approx(ARM_SPECIAL_CASE)
    assert np.sqrt(((places - ARM_SPECIAL_CASE) ** 2).mean()) == pytest.approx(
        np.sqrt(2.0 / 3.0) * np.linalg.norm(ARM_SPECIAL_CASE) / np.sqrt(3.0)
    )


def test_what_is_expected_is_what_departures_show_on_average() -> None:
    rng = np.random.default_rng(5)
    size = np.linalg.norm(ARM_SPECIAL_CASE) / np.sqrt(3.0)
    none = left_by_a_lever_arm(np.zeros(9))
    drawn = [left_by_a_lever_arm(size * rng.standard_normal(9)) - none for _ in range(24)]
    assert np.mean(drawn) == pytest.approx(shown(RUN), rel=0.3)


def test_a_unit_that_hardly_turns_shows_nothing() -> None:
    slow = replace(RUN, rate=0.02 * RUN.rate, acceleration=0.02 * RUN.acceleration)
    assert shown(slow) < 0.01 * shown(RUN)


def test_some_of_the_places_show_less_than_all() -> None:
    assert 0.0 < shown(RUN, (0, 1, 2, 3, 4)) < shown(RUN)


def test_about_one_axis_no_departure_shows() -> None:
    turning = replace(RUN, rate=RUN.rate * (0, 0, 1), acceleration=RUN.acceleration * (0, 0, 1))
    assert shown(turning) < 1e-6 * shown(RUN)


# What a recording cannot tell apart is named beside what was selected, and nothing else is.

REST, GAP = 20.0, 14.0  # s
STEP = 1.2e-3  # rad/s


def searched(readings: np.ndarray, *terms: Term) -> Selection:
    run = motion()
    readings = readings + noise(len(run.t), 7, NOISY)
    blocks = observed(readings, run)
    candidates, columns = candidates_of(terms, run)
    half = plausible_half_ranges(candidates, len(columns))
    design = banded_design(blocks, readings, columns, half)
    return with_rivals(search(design, candidates, (), NOISY), design, candidates)


def jumping(at: float, seed: int) -> Recording:
    """Six labelled rests, and a gyro whose bias jumps once, at a time (s)."""
    t, readings, segments = labelled_rests(seed, REST, GAP)
    readings[t >= at, 0] += STEP
    return recording_of(t, readings, segments)


def test_what_differs_in_the_motion_has_no_rivals() -> None:
    warming = (4e-6, 0.0, -3e-6, 0.0, 1e-4, 0.0)
    made = read(motion(), (LEVER_ARM, (0.004, -0.006, 0.003)), (TEMPERATURE_BIAS, warming))
    found = searched(made, LEVER_ARM, TEMPERATURE_BIAS, TIME_OFFSET, earth_rotation(0.7))
    assert {one.candidate.name: one.rivals for one in found.selected} == {
        "lever_arm": (), "temperature_bias": (),
    }  # fmt: skip


@pytest.mark.rehearsal
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.rehearsal)])
def test_a_jump_between_two_positions_is_not_told_from_the_square_of_gravity(seed: int) -> None:
    """After +x and −x the square of the force jumps once as well, and no rest saw it happen."""
    (found,) = explain(jumping(2 * REST + GAP + 3.0, seed)).findings
    assert {found.effect, *found.indistinguishable} == {"bias_step", "gyro_g2_sensitivity"}


@pytest.mark.rehearsal
def test_a_jump_within_a_rest_is_no_square_of_gravity() -> None:
    (found,) = explain(jumping(2 * (REST + GAP) + 8.0, 1)).findings
    assert (found.effect, found.indistinguishable) == ("bias_step", ())


# Scores of candidates: what a gain is worth.

ARM_SCORES = Candidate(LEVER_ARM, (0,), (0,), 1)
FREE = Candidate(sinusoid(GYROS).shaped((60.0,)), (1,), (0,), 1)


@pytest.mark.parametrize(("more", "first"), [(0.001, "lever_arm"), (0.003, "unnamed")])
def test_a_free_form_must_gain_more_than_the_reference_errs_by(more: float, first: str) -> None:
    """Of a chi-squared of a million, in which a thousandth is certain and means nothing."""
    gains = 1e6 * np.array([1.0, 1.0 + more])
    equations = NormalEquations(np.eye(2), np.sqrt(gains), np.ones(2), 2e6)
    ranked = rank(equations, [ARM_SCORES, FREE], ())
    assert ranked[0].candidate.name == first
    assert {one.candidate.name: one.gain for one in ranked} == pytest.approx(
        dict(zip(("lever_arm", "unnamed"), gains, strict=True)), rel=1e-5
    )
