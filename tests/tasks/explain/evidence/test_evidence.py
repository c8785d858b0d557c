"""What a finding earns, and which findings are no more than chance."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from engine_run import (
    MOVE,
    NOISY,
    QUIET,
    RATE,
    REST,
    WHITE,
    motion,
    noise,
    observed,
    read,
    selected,
)

from schemas.discrepancy import HeldOut
from tasks.explain.evidence.cells import (
    CELL_LENGTH,
    FOLDS,
    CrossValidation,
    cell_equations,
    cross_validation,
    fold_cells,
)
from tasks.explain.evidence.evidence import (
    Evidence,
    FindingGroup,
    change_without,
    finding_groups,
    step_time,
    unsupported,
)
from tasks.explain.evidence.findings import _beside_implausible, scrutinised
from tasks.explain.explanation import CHANNELS, UNNAMED
from tasks.explain.noise import Noise
from tasks.explain.search.candidates import Candidate, Prior
from tasks.explain.search.design import NormalEquations
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.stepwise import Selected, Selection
from tasks.model.model import linearise
from tasks.model.term import Column, Term, nominal_values
from tasks.model.terms.environment import TEMPERATURE_BIAS, THERMAL_GRADIENT
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.memory import bias_step
from tasks.model.terms.site import earth_rotation
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.model.terms.table import rate_ripple
from tasks.model.terms.timing import TIME_OFFSET
from tasks.motion.whole import Motion

RUN = motion()
EARTH = earth_rotation(np.radians(40.0))
ARM = (0.004, -0.006, 0.003)
TRIED = 300  # candidates


def picked(
    term: Term,
    own: tuple[int, ...] | None = None,
    prior: Prior | None = None,
    absorbed_by: str | None = None,
) -> Selected:
    own = tuple(range(len(term.parameters))) if own is None else own
    return Selected(Candidate(term, own or (0,), own, 1, prior), 100.0, 90.0, (), absorbed_by)


def found(*chosen: Selected) -> Selection:
    nothing = NormalEquations(np.zeros((0, 0)), np.zeros(0), np.zeros(0), 0.0)
    return Selection(chosen, NOISY, 0.0, nothing)


def weighed(made: np.ndarray, chosen: Sequence[Selected]) -> tuple[Evidence, list[FindingGroup]]:
    free = [replace(one, candidate=replace(one.candidate, prior=None)) for one in chosen]
    fit = FittedSelection.of(found(*free), observed(made, RUN), RATE)
    evidence = Evidence.of(replace(fit, selection=found(*chosen)))
    return evidence, list(evidence.groups)


@pytest.fixture(scope="module")
def three() -> tuple[Evidence, list[FindingGroup]]:
    """An arm that is there, Earth that is there, a gradient that is not."""
    made = read(RUN, (EARTH, ()), (LEVER_ARM, ARM)) + noise(len(RUN.t), 41, NOISY)
    return weighed(made, [picked(LEVER_ARM), picked(THERMAL_GRADIENT), picked(EARTH)])


def test_the_same_name_is_one_finding() -> None:
    parts = [picked(TEMPERATURE_BIAS, (0,)), picked(LEVER_ARM), picked(TEMPERATURE_BIAS, (4,))]
    groups = finding_groups(found(*parts))
    assert [group.name for group in groups] == ["temperature_bias", "lever_arm"]
    assert groups[0].terms == (TEMPERATURE_BIAS,)
    assert groups[0].selected == (parts[0], parts[2])


def test_two_steps_are_jumps_without_a_name_and_one_is_a_step() -> None:
    first, later = bias_step(0, 100.0), replace(bias_step(0, 250.0), variant=1)
    (jumps,) = finding_groups(found(picked(first, (0,)), picked(later, (0,))))
    assert (jumps.name, len(jumps.terms)) == (UNNAMED, 2)
    (once,) = finding_groups(found(picked(first, (0,)), picked(first, (1,))))
    assert once.name == "bias_step"
    (both,) = finding_groups(found(picked(first), picked(bias_step(3, 100.0))))
    assert both.name == "bias_step"  # gyros and accelerometers at the same moment
    soon = picked(bias_step(3, 102.0))
    assert finding_groups(found(picked(first), soon))[0].name == "bias_step"


@pytest.mark.parametrize(
    ("orders", "name"), [((6, 7, 8), UNNAMED), ((7, 14), "rate_ripple"), ((7,), "rate_ripple")]
)
def test_neighbouring_orders_of_a_ripple_are_something_at_one_place_of_the_turn(
    orders: tuple[int, ...], name: str
) -> None:
    (one,) = finding_groups(found(*(picked(rate_ripple(order, 1)) for order in orders)))
    assert one.name == name


def test_the_gain_is_the_chi_squared_of_what_was_found(
    three: tuple[Evidence, list[FindingGroup]],
) -> None:
    """Of physics without a parameter: of a fit without it, less one with it at its own size."""
    one, groups = three
    made = read(RUN, (EARTH, ()), (LEVER_ARM, ARM)) + noise(len(RUN.t), 41, NOISY)
    other, _ = weighed(made, [picked(LEVER_ARM), picked(THERMAL_GRADIENT)])
    rows = slice(0, other.whole.count)
    chi2 = []
    for each in (other, one):  # what is known comes behind what is fitted
        normal, right, misfit = each.whole.normal()
        block = normal[rows, rows] + np.diag(each.prior[rows])
        chi2.append(misfit - right[rows] @ np.linalg.pinv(block, rcond=1e-12) @ right[rows])
    assert one.gain([group.name for group in groups].index("earth_rotation")) == pytest.approx(
        chi2[0] - chi2[1], rel=0.02
    )


def test_what_is_there_is_needed_and_what_is_not_is_needless(
    three: tuple[Evidence, list[FindingGroup]],
) -> None:
    one, groups = three
    weak = {group.name: unsupported(one, n, TRIED) for n, group in enumerate(groups)}
    assert weak == {"lever_arm": False, "thermal_gradient": True, "earth_rotation": False}


def test_what_is_there_earns_on_segments_that_were_not_seen(
    three: tuple[Evidence, list[FindingGroup]],
) -> None:
    one, groups = three
    earned = {group.name: one.held_out_gain(n) for n, group in enumerate(groups)}
    assert earned["lever_arm"] > 50.0
    assert earned["earth_rotation"] > 10.0
    assert earned["thermal_gradient"] < 5.0


def test_unseen_segments_are_noise_after_and_worse_before(
    three: tuple[Evidence, list[FindingGroup]],
) -> None:
    text: HeldOut = three[0].held_out(np.zeros(6))
    assert text.chi2_per_dof_after == pytest.approx(1.0, abs=0.05)
    assert text.chi2_per_dof_before > text.chi2_per_dof_after
    assert set(text.rms_ratio) == set(CHANNELS)
    assert max(text.rms_ratio.values()) < 1.01
    assert min(text.rms_ratio.values()) < 0.98


def test_what_events_remove_is_missing_from_unseen_segments_before(
    three: tuple[Evidence, list[FindingGroup]],
) -> None:
    evidence, removed = three[0], np.array([0.0, 0.0, 0.0, 3.0, 0.0, 0.0])
    plain, beside = evidence.held_out(np.zeros(6)), evidence.held_out(removed)
    assert beside.chi2_per_dof_after == plain.chi2_per_dof_after
    more = beside.chi2_per_dof_before - plain.chi2_per_dof_before
    assert more == pytest.approx(3.0 / 6, rel=0.01)  # one of six channels
    powers = [one.rms_ratio["accel_x"] ** -2 for one in (plain, beside)]  # before, over noise
    assert powers[1] - powers[0] == pytest.approx(3.0, rel=0.05)
    assert beside.rms_ratio["gyro_x"] == plain.rms_ratio["gyro_x"]


def test_random_drifts_and_what_is_absorbed_are_not_judged_by_a_gain() -> None:
    """The first are charged by their evidence; of the others no residual is left."""
    made = read(RUN) + noise(len(RUN.t), 42, NOISY)
    series = picked(THERMAL_GRADIENT, prior=Prior(2.0, 1.0))
    absorbed = picked(LEVER_ARM, absorbed_by="gyro_g_sensitivity")
    one, groups = weighed(made, [series, absorbed])
    assert [unsupported(one, n, TRIED) for n in range(len(groups))] == [False, False]


# Segments that a fit did not see are predicted by what it learnt from the others.


def columns(run: Motion = RUN) -> list[Column]:
    """The standard's, then three of the lever arm."""
    terms = (*STANDARD_TERMS, LEVER_ARM)
    return list(linearise(terms, run, nominal_values(terms)).columns)


def found_cells(
    made: np.ndarray, every: Sequence[Column], noises: Sequence[Noise]
) -> CrossValidation:
    blocks, misfit = observed(made, RUN), made - read(RUN)
    return cross_validation(cell_equations(every, misfit, blocks, noises, fold_cells(blocks)))


def predicted(made: np.ndarray, more: Sequence[Column], kept: list[int]) -> float:
    """Twice the nats that every fold costs, as a fit of some columns to the others tells it."""
    every = [*columns()[:-3], *more]
    zero = np.zeros(len(every))
    return found_cells(made, every, NOISY).joint_deviance(kept, zero, zero)[0]


def test_a_fold_is_every_fourth_segment_with_the_move_before_it() -> None:
    blocks = observed(read(RUN), RUN)
    turn = (RUN.t // (REST + MOVE)).astype(int)
    resting = RUN.t % (REST + MOVE) < REST
    fold = fold_cells(replace(blocks, segment=np.where(resting, turn, -1))) % FOLDS
    for k in range(1, 20):
        with_move = (RUN.t >= k * (REST + MOVE) - MOVE) & (RUN.t < k * (REST + MOVE) + REST)
        assert set(fold[with_move].tolist()) == {k % FOLDS}
    np.testing.assert_array_equal(fold_cells(blocks), blocks.segment)


def test_a_run_without_segments_is_cut_by_time() -> None:
    blocks = replace(observed(read(RUN), RUN), segment=np.full(len(RUN.t), -1))
    fold = fold_cells(blocks) % FOLDS
    changes = np.flatnonzero(np.diff(fold))
    assert np.diff(changes) == pytest.approx(CELL_LENGTH * RATE)
    assert np.bincount(fold).min() > 0.2 * len(fold)


def test_a_fold_is_predicted_as_gausss_formula_has_it() -> None:
    """By what the rows outside it tell, and how surely; in white noise, row by row."""
    run = RUN.taken(np.arange(0, len(RUN.t), 40))
    made = read(run, (LEVER_ARM, ARM)) + noise(len(run.t), 20, QUIET)
    every, blocks, misfit = columns(run), observed(made, run, RATE / 40), made - read(run)
    parts = cross_validation(cell_equations(every, misfit, blocks, QUIET, fold_cells(blocks)))
    zero = np.zeros(len(every))
    sigma = np.sqrt([one.white for one in QUIET])
    design = np.zeros((6, len(run.t), len(every)))
    for q, column in enumerate(every):
        for channel, series in column.items():
            design[channel, :, q] = series / sigma[channel]
    fold, total, joint = fold_cells(blocks) % FOLDS, np.zeros(6), np.zeros(7)
    for k in range(FOLDS):
        rows = design[:, fold != k].reshape(-1, len(every))
        target = (misfit / sigma)[fold != k].T.ravel()
        size = np.linalg.norm(rows, axis=0)
        known = np.linalg.inv((rows / size).T @ (rows / size))
        values = known @ ((rows / size).T @ target)
        for channel in range(6):
            hidden = design[channel, fold == k] / size
            left = (misfit / sigma)[fold == k, channel] - hidden @ values
            spread = np.eye(len(left)) + hidden @ known @ hidden.T
            total[channel] += left @ np.linalg.solve(spread, left) + np.linalg.slogdet(spread)[1]
        for without in range(7):  # the last: all channels
            some = [c for c in range(6) if c != without]
            hidden = design[some][:, fold == k].reshape(-1, len(every)) / size
            left = (misfit / sigma)[fold == k][:, some].T.ravel() - hidden @ values
            spread = np.eye(len(left)) + hidden @ known @ hidden.T
            joint[without] += left @ np.linalg.solve(spread, left) + np.linalg.slogdet(spread)[1]
    kept = list(range(len(every)))
    np.testing.assert_allclose(parts.deviance(kept, zero, zero), total, rtol=1e-5)
    together, beside = parts.joint_deviance(kept, zero, zero)
    assert together == pytest.approx(joint[6], rel=1e-5)
    np.testing.assert_allclose(beside, joint[6] - joint[:6], rtol=1e-4)


def test_the_part_that_is_not_fitted_is_put_back() -> None:
    """A finding is left out by adding what it says to the misfit and not fitting it again."""
    made = read(RUN, (LEVER_ARM, ARM)) + noise(len(RUN.t), 23, NOISY)
    every, count = columns(), len(columns())
    zero, added = np.zeros(count), np.zeros(count)
    added[-3:] = ARM
    kept = list(range(count - 3))
    without = found_cells(made, every, NOISY)
    known = found_cells(made - read(RUN, (LEVER_ARM, ARM)) + read(RUN), every, NOISY)
    np.testing.assert_allclose(
        known.deviance(kept, added, zero), without.deviance(kept, zero, zero), rtol=1e-6
    )


def test_what_is_known_beforehand_is_not_learnt_anew() -> None:
    made = read(RUN, (TEMPERATURE_BIAS, np.full(6, 1e-4))) + noise(len(RUN.t), 24, QUIET)
    every: list[Column] = [*columns(), {0: RUN.recorded["temperature"] - 25.0}]
    parts = found_cells(made, every, QUIET)
    zero, held = np.zeros(len(every)), np.zeros(len(every))
    held[-1] = 1e30
    kept = list(range(len(every)))
    firm, free = parts.deviance(kept, zero, held)[0], parts.deviance(kept, zero, zero)[0]
    assert firm == pytest.approx(parts.deviance(kept[:-1], zero, zero)[0], rel=1e-6)
    assert free < 0.5 * firm


# The stated time of a step holds the true one, and a gap of the readings widens it.

TRUE = 163.211  # s, between two blocks
NOTHING = NormalEquations(np.zeros((0, 0)), np.zeros(0), np.zeros(0), 0.0)


def timed(made: np.ndarray, at: float, **changes: Any) -> tuple[float, float]:
    """The time of a step of gyro y that a search put at a time, s, and its u."""
    step, blocks = bias_step(0, at), replace(observed(made, RUN), **changes)
    picked = Selected(Candidate(step, (1,), (1,), 1), 100.0, 90.0, ())
    fit = FittedSelection.of(Selection((picked,), NOISY, 1e-9, NOTHING), blocks, RATE)
    return step_time(fit, fit.model.terms[-1], 1.0)


def stepped(size: float, seed: int) -> np.ndarray:
    """Readings with a step of gyro y, in standard deviations of a block."""
    made = read(RUN) + noise(len(RUN.t), seed, QUIET)
    made[RUN.t >= TRUE, 1] += size * WHITE[1]
    return made


@pytest.mark.parametrize("size", [0.7, 1.5, 6.0])
def test_the_expanded_uncertainty_covers_the_true_time(size: float) -> None:
    inside = []
    for seed in range(16):
        time, u = timed(stepped(size, seed), TRUE)
        inside.append(abs(time - TRUE) <= 2.0 * u)
        assert 0.0 < 2.0 * u < 60.0 / RATE / size**2 + 2.0 / RATE
    assert np.mean(inside) >= 0.9


def test_in_a_gap_of_the_readings_it_may_lie_anywhere() -> None:
    weight = np.where((RUN.t > 155.0) & (RUN.t < 175.0), 0.0, 1.0)[:, None].repeat(6, axis=1)
    time, u = timed(stepped(6.0, 3), 175.0, weight=weight)
    assert time == pytest.approx(165.0, abs=0.2)
    assert 2.0 * u == pytest.approx(10.0, abs=0.2)


@pytest.mark.parametrize("unknown", [(155.0, 175.0), (390.0, 400.0)])
def test_unknown_motion_is_as_a_gap_of_the_readings(unknown: tuple[float, float]) -> None:
    hidden = (RUN.t > unknown[0]) & (RUN.t < unknown[1])
    weight = np.where(hidden, 0.0, 1.0)[:, None].repeat(6, axis=1)
    lost = RUN.mapped(lambda values: np.where(hidden.reshape(-1, *[1] * (values.ndim - 1)),
                                              np.nan, values))  # fmt: skip
    lost = replace(lost, t=RUN.t)
    at = 175.0 if hidden[np.searchsorted(RUN.t, TRUE)] else TRUE
    known = timed(stepped(1.0, 6), at, weight=weight)
    assert timed(stepped(1.0, 6), at, weight=weight, motion=lost) == pytest.approx(known, abs=0.02)


def test_a_band_of_poses_shows_no_time_more_closely_than_its_edge() -> None:
    _, u = timed(stepped(30.0, 4), TRUE, band=2.0)
    assert 2.0 * u == pytest.approx(0.25, abs=0.1)


# Beside an implausible finding, what the others would be without it.

ARM_DEPENDENCE = np.array([0.04, -0.06, 0.03])
LONG = 3.0 * LEVER_ARM.parameters[0].plausible[1] * np.ones(3)


def readings(delay: float, arm: np.ndarray) -> np.ndarray:
    """(n, 6) of a unit with a delay in s and a lever arm in m."""
    return read(RUN, (TIME_OFFSET, [delay]), (LEVER_ARM, arm)) + noise(len(RUN.t), 54, NOISY)


def test_u_as_stated_covers_what_a_parameter_would_be_without_what_is_implausible() -> None:
    """A delay of 20 ms beside a lever arm three times too long."""
    made = readings(0.02, LONG)
    both, alone = (
        Evidence.of(selected(made, TIME_OFFSET, LEVER_ARM)),
        selected(made, TIME_OFFSET).model,
    )
    change = np.abs(alone.values[alone.places[TIME_OFFSET.key]] - both.values[both.own[0]])
    found = scrutinised(both)
    stated = _beside_implausible(both, found)
    assert found[0].u < 0.1 * change
    assert stated[0].u == pytest.approx(change, rel=0.1)
    assert stated[1].u == pytest.approx(found[1].u)


def test_what_is_named_and_what_is_determined_stays() -> None:
    """A delay a tenth beyond what is plausible, beside a lever arm known to 20 µm."""
    made = readings(1.1 * TIME_OFFSET.parameters[0].plausible[1], ARM_DEPENDENCE)
    both = Evidence.of(selected(made, TIME_OFFSET, LEVER_ARM))
    found = scrutinised(both)
    assert [one.refusal and one.refusal.kind for one in found.values()] == ["implausible", None]
    assert (found[1].u < 1e-4).all()
    assert (change_without(both, [0])[both.own[1]] > 1e-3).any()
