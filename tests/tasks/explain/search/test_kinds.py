"""Where kinds of behaviour are tried, and which forms and empirical terms stand beside them."""

from dataclasses import replace

import numpy as np
import pytest
from engine_run import motion

from tasks.explain.channels import GYROS
from tasks.explain.explanation import UNNAMED
from tasks.explain.search.behaviours import UnlistedForm
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.empirical import empirical
from tasks.explain.search.kinds import with_kinds
from tasks.explain.search.stepwise import Selected
from tasks.model.model import Model
from tasks.model.term import Inputs, Term
from tasks.model.terms import hysteresis as memories
from tasks.model.terms.environment import TEMPERATURE_BIAS
from tasks.model.terms.gyro import gyro_dead_band
from tasks.model.terms.timing import TIME_OFFSET

RUN = motion()
U = 1e-5
DEAD_BAND = gyro_dead_band(0.05)
(PLAYS, *_) = (one for one in memories._OF_GYROS if one.source == memories.PLAYS)
MEMORY = memories.hysteresis(0.1)
LISTED: tuple[Term, ...] = (PLAYS, MEMORY, DEAD_BAND, TEMPERATURE_BIAS, TIME_OFFSET)
FOLLOWS = empirical(RUN)[0]


def tried(
    *selected: Term, size: float = 0.0, nuisance: bool = False, gains: tuple[float, ...] = ()
) -> tuple[Term, ...]:
    """Terms of the second search after a first one selected some, every value of one size."""
    whole = Model.of(selected)
    count = len(whole.values)
    model = replace(whole, values=np.full(count, size), covariance=U**2 * np.eye(count))
    own = [tuple(range(len(term.parameters))) for term in selected]
    found = [
        Selected(Candidate(term, numbers, numbers, 1, nuisance=nuisance), gain, gain)
        for term, numbers, gain in zip(selected, own, gains or count * (50.0,), strict=False)
    ]
    return with_kinds(LISTED, found, model, RUN)


def kinds(terms: tuple[Term, ...]) -> set[str]:
    return {term.name for term in terms if isinstance(term, UnlistedForm)}


def test_what_has_no_name_may_be_any_kind_of_behaviour() -> None:
    assert {"hysteresis", "gyro_scale_nonlinearity", "vibration_rectification"} < kinds(
        tried(FOLLOWS)
    )


@pytest.mark.parametrize("selected", [(), (MEMORY,), (TEMPERATURE_BIAS,)])
def test_a_listed_form_is_not_questioned(selected: tuple[Term, ...]) -> None:
    assert not tried(*selected, size=1.0)


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


@pytest.mark.parametrize(("size", "questioned"), [(-0.5, False), (U, False), (4.0 * U, True)])
def test_friction_that_would_add_is_another_form(size: float, questioned: bool) -> None:
    terms = tried(DEAD_BAND, size=size)
    assert bool(terms) is questioned
    assert DEAD_BAND not in terms


def test_empirical_terms_that_a_kind_has_among_its_forms_do_not_compete_with_it() -> None:
    beside = tried(FOLLOWS)
    left_out = {one.equation for one in empirical(RUN)} - {one.equation for one in beside}
    assert {"reading += c·ω_i²", "reading += c·lag(ω², 7 s)"} < left_out
    (sizes,) = (one for one in beside if one.equation == "reading += c·|ω_j|")
    channels = {c for column in sizes.columns(RUN, Inputs.of(RUN)) for c in column}
    assert channels == set(GYROS)  # no kind of behaviour of a gyro follows the other rates


def test_other_empirical_terms_compete_with_the_kinds() -> None:
    equations = {one.equation for one in tried(FOLLOWS) if one.name == UNNAMED}
    assert {"reading += c·lag(ω, 7 s)", "reading += c·lag(f, 45 s)"} < equations
