"""What makes up for each other: which stands, and what is left as it is."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from engine_run import NOISY, motion, noise, observed, read

from tasks.explain.evidence.confounding import Combination, common_part, shape_count
from tasks.explain.evidence.confounding import compared as compared_with
from tasks.explain.search.candidates import Candidate, columns_of
from tasks.explain.search.design import banded_design
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.stepwise import Selected, search
from tasks.model.term import Column, Term
from tasks.model.terms.electronics import BANDWIDTH, BANDWIDTH_BY_TRIAD
from tasks.model.terms.environment import TEMPERATURE_BIAS, thermal_transient
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.gyro import GYRO_ANGULAR_ACCELERATION
from tasks.model.terms.timing import TIME_OFFSET

RUN = motion()
DELAY, ARM = 0.006, (0.012, -0.018, 0.007)


@cache
def found(*nuisances: str) -> tuple[FittedSelection, tuple[Candidate, ...]]:
    """A delay and a lever arm, read; a delay, a low-pass and a lever arm, fitted to it."""
    made = read(RUN, (TIME_OFFSET, (DELAY,)), (LEVER_ARM, ARM)) + noise(len(RUN.t), 3, NOISY)
    blocks = observed(made, RUN)
    terms: list[Term] = [TIME_OFFSET, BANDWIDTH, LEVER_ARM]
    columns: list[Column] = []
    whole: list[Candidate] = []
    for term in terms:
        own = tuple(range(len(term.parameters)))
        members = tuple(len(columns) + q for q in own)
        whole.append(Candidate(term, members, own, 1, nuisance=term.name in nuisances))
        columns += columns_of(term, RUN)
    design = banded_design(blocks, made, columns, np.full(len(columns), np.inf))
    kept = tuple(Selected(one, 1.0, 1.0, ()) for one in whole)
    selection = replace(search(design, whole, (), NOISY), selected=kept)
    return FittedSelection.of(selection, blocks, blocks.rate), tuple(whole)


def filtered_and_early() -> tuple[FittedSelection, list[Candidate]]:
    """Accelerometers that are filtered, and stamps that are early by nearly as much; found as a
    delay, and gyros that feel the angular acceleration.
    """
    filtered = read(RUN, (BANDWIDTH_BY_TRIAD, (0.0, 0.0068)), (TIME_OFFSET, (-0.007,)))
    made = filtered + noise(len(RUN.t), 5, NOISY)
    blocks = observed(made, RUN)
    columns: list[Column] = []
    whole: list[Candidate] = []
    for term in (TIME_OFFSET, BANDWIDTH_BY_TRIAD, GYRO_ANGULAR_ACCELERATION):
        own = tuple(range(len(term.parameters)))
        whole.append(Candidate(term, tuple(len(columns) + q for q in own), own, 1))
        columns += columns_of(term, RUN)
    design = banded_design(blocks, made, columns, np.full(len(columns), np.inf))
    kept = tuple(Selected(one, 1.0, 1.0, ()) for one in (whole[0], whole[2]))
    selection = replace(search(design, whole, (), NOISY), selected=kept)
    return FittedSelection.of(selection, blocks, blocks.rate), whole


def compared(fit: FittedSelection, candidates: Sequence[Candidate]) -> FittedSelection:
    """Where nothing else was selected that would be pruned."""
    return compared_with(fit, candidates, lambda one, kept: one)


def names(fit: FittedSelection) -> set[str]:
    return {one.name for one in fit.selection.candidates}


def seconds(fit: FittedSelection) -> float:
    return float(fit.model.values[fit.model.places[TIME_OFFSET.key]][0])


def test_a_nuisance_stays_and_what_makes_up_for_it_is_left_out() -> None:
    fit, candidates = found("time_offset")
    after = compared(fit, candidates)
    assert names(after) == {"time_offset", "lever_arm"}
    assert seconds(after) == pytest.approx(DELAY, abs=1e-3)
    assert not any(one.group for one in after.selection.selected)


def test_two_effects_are_no_likelier_than_a_filter_that_a_lead_cancels() -> None:
    after = compared(*filtered_and_early())
    groups = [set(one.group) for one in after.selection.selected]
    assert {"time_offset", "bandwidth", "gyro_angular_acceleration"} in groups


def test_a_time_constant_costs_as_much_as_a_parameter() -> None:
    warm_up = thermal_transient(60.0)
    (bias, one, other) = (
        Candidate(term, (), (), 1) for term in (TEMPERATURE_BIAS, warm_up, warm_up)
    )
    assert shape_count((bias,)) == 0
    assert shape_count((one, other)) == 1


def test_each_of_several_forms_promises_what_it_promises_alone() -> None:
    fit, candidates = found()
    arm = next(one for one in candidates if one.name == "lever_arm")
    delay = next(one for one in candidates if one.name == "time_offset")
    only = fit.without([one for one in fit.selection.selected if one.candidate.name != "bandwidth"])
    held = Combination(tuple(only.selection.candidates), only)
    both = held.promises([(arm,), (delay,)])
    assert both == pytest.approx([held.promises([(arm,)])[0], held.promises([(delay,)])[0]])
    assert both[0] > 1000.0


def test_a_value_beyond_what_a_unit_may_have_is_not_plausible() -> None:
    fit, _ = found()
    members = tuple(one for one in fit.selection.candidates if one.name == "lever_arm")
    assert Combination(members, fit).plausible
    values = fit.model.values.copy()
    values[fit.model.places[LEVER_ARM.key]] = 2.0 * LEVER_ARM.parameters[0].plausible[1]
    far = replace(fit, model=replace(fit.model, values=values))
    assert not Combination(members, far).plausible


@pytest.mark.parametrize(("late", "is_plausible"), [(0.001, True), (-0.012, False)])
def test_a_low_pass_that_a_lead_takes_back_is_not_plausible(
    late: float, is_plausible: bool
) -> None:
    fit, _ = found()
    members = tuple(
        one for one in fit.selection.candidates if one.name in ("time_offset", "bandwidth")
    )
    values = fit.model.values.copy()
    values[fit.model.places[TIME_OFFSET.key]] = late
    values[fit.model.places[BANDWIDTH.key]] = 0.0088
    both = replace(fit, model=replace(fit.model, values=values))
    assert Combination(members, both).plausible is is_plausible


def test_the_common_part_is_as_uncertain_as_its_widened_parameters() -> None:
    fit, _ = found()
    delay = fit.without(
        [one for one in fit.selection.selected if one.candidate.name == "bandwidth"]
    )
    u = float(delay.model.u[delay.model.places[TIME_OFFSET.key]][0])
    wider = np.full(len(delay.model.values), 3.0)
    gyro, accel = common_part(delay.model, [TIME_OFFSET], ("time_offset", "bandwidth"), wider)
    assert gyro.u == accel.u == pytest.approx(3.0 * u)
    assert gyro.value == pytest.approx(seconds(delay))


def test_what_makes_gyros_alone_late_says_nothing_of_accelerometers() -> None:
    fit, _ = found()
    names = ("time_offset", "gyro_angular_acceleration")
    common = common_part(fit.model, [TIME_OFFSET], names, np.ones(len(fit.model.values)))
    assert [one.name for one in common] == ["gyro_group_delay"]
