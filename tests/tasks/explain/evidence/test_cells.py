"""Segments that a fit did not see are predicted by what it learnt from the others."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from engine_run import MOVE, NOISY, QUIET, RATE, REST, motion, noise, observed, read

from tasks.explain.evidence.cells import (
    CELL_LENGTH,
    FOLDS,
    CrossValidation,
    cell_equations,
    cross_validation,
    fold_cells,
)
from tasks.explain.whitening import Noise
from tasks.model.simulate import linearise
from tasks.model.term import Column, nominal_values
from tasks.model.terms.environment import TEMPERATURE_BIAS
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.whole import Motion

RUN = motion()
ARM = (0.004, -0.006, 0.003)


def columns(run: Motion = RUN) -> list[Column]:
    """The standard's, then three of the lever arm."""
    terms = (*STANDARD_TERMS, LEVER_ARM)
    return list(linearise(terms, run, nominal_values(terms)).columns)


def found(made: np.ndarray, every: Sequence[Column], noises: Sequence[Noise]) -> CrossValidation:
    blocks, misfit = observed(made, RUN), made - read(RUN)
    return cross_validation(cell_equations(every, misfit, blocks, noises, fold_cells(blocks)))


def predicted(made: np.ndarray, more: Sequence[Column], kept: list[int]) -> float:
    """Twice the nats that every fold costs, as a fit of some columns to the others tells it."""
    every = [*columns()[:-3], *more]
    zero = np.zeros(len(every))
    return found(made, every, NOISY).joint_deviance(kept, zero, zero)[0]


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
    without = found(made, every, NOISY)
    known = found(made - read(RUN, (LEVER_ARM, ARM)) + read(RUN), every, NOISY)
    np.testing.assert_allclose(
        known.deviance(kept, added, zero), without.deviance(kept, zero, zero), rtol=1e-6
    )


def test_what_is_known_beforehand_is_not_learnt_anew() -> None:
    made = read(RUN, (TEMPERATURE_BIAS, np.full(6, 1e-4))) + noise(len(RUN.t), 24, QUIET)
    every: list[Column] = [*columns(), {0: RUN.recorded["temperature"] - 25.0}]
    parts = found(made, every, QUIET)
    zero, held = np.zeros(len(every)), np.zeros(len(every))
    held[-1] = 1e30
    kept = list(range(len(every)))
    firm, free = parts.deviance(kept, zero, held)[0], parts.deviance(kept, zero, zero)[0]
    assert firm == pytest.approx(parts.deviance(kept[:-1], zero, zero)[0], rel=1e-6)
    assert free < 0.5 * firm
