"""Gram matrices by bands say what one least-squares fit of all whitened samples would say."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from engine_run import (
    NOISY,
    QUIET,
    chi2,
    motion,
    noise,
    observed,
    read,
    whitened,
    with_weight,
)

from tasks.explain.inputs.blocks import Blocks
from tasks.explain.search.candidates import columns_of
from tasks.explain.search.design import (
    BandedDesign,
    banded_design,
    normal_equations,
    residual_noises,
    residuals,
    with_columns,
)
from tasks.explain.search.stepwise import initial_noises
from tasks.model.fit import inverse
from tasks.model.term import Column
from tasks.model.terms.environment import TEMPERATURE_BIAS
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.standard import regressors
from tasks.model.terms.timing import TIME_OFFSET

RUN = motion()
LEVER = (0.012, -0.018, 0.007)
COLUMNS: tuple[Column, ...] = tuple(
    column for term in (LEVER_ARM, TEMPERATURE_BIAS, TIME_OFFSET)
    for column in columns_of(term, RUN)
)  # fmt: skip
FREE = np.full(len(COLUMNS), np.inf)  # nothing is known of them beforehand


class Small(NamedTuple):
    blocks: Blocks
    readings: np.ndarray
    pool: BandedDesign


@pytest.fixture(scope="module")
def small() -> Small:
    """A unit on a lever arm, with weights that differ from block to block and a gap."""
    readings = read(RUN, (LEVER_ARM, LEVER)) + noise(len(RUN.t), 1, NOISY)
    weight = 0.5 + 0.5 * np.random.default_rng(2).random(len(RUN.t))
    weight[3000:3100] = 0.0
    blocks = with_weight(observed(readings, RUN), {0: weight, 4: weight})
    return Small(blocks, readings, banded_design(blocks, readings, COLUMNS, FREE))


def test_the_misfit_of_the_standard_model_is_that_of_least_squares(small: Small) -> None:
    direct, _ = chi2(small.pool, small.readings, (), NOISY)
    assert normal_equations(small.pool, NOISY).misfit == pytest.approx(direct, rel=1e-4)


@pytest.mark.parametrize("which", [[0], [0, 1, 2], [3, 7], [9], list(range(10))])
def test_gain_and_values_are_those_of_least_squares(small: Small, which: list[int]) -> None:
    state = normal_equations(small.pool, NOISY)
    block, right = state.normal[np.ix_(which, which)], state.right[which]
    values = inverse(block) @ right
    before, _ = chi2(small.pool, small.readings, (), NOISY)
    after, direct = chi2(small.pool, small.readings, [COLUMNS[p] for p in which], NOISY)
    u = np.sqrt(np.diag(inverse(block)))
    assert right @ values == pytest.approx(before - after, rel=1e-4, abs=0.05)
    assert np.abs(values - direct / state.scale[which]).max() < 0.01 * u.max()


def test_an_effect_of_several_channels_has_one_parameter(small: Small) -> None:
    """A delay is seen by all six channels; each alone would tell less of it than all together."""
    delay = len(COLUMNS) - 1
    assert len(COLUMNS[delay]) > 3
    size = 1.0 / normal_equations(small.pool, NOISY).scale[delay] ** 2
    alone = []
    for channel in COLUMNS[delay]:
        one = {channel: COLUMNS[delay][channel]}
        pool = banded_design(small.blocks, small.readings, (one,), np.array([np.inf]))
        alone.append(1.0 / normal_equations(pool, NOISY).scale[0] ** 2)
    assert size == pytest.approx(sum(alone), rel=1e-4)


def test_what_the_standard_model_says_too_is_not_seen(small: Small) -> None:
    shifted = {0: 2.0 * RUN.rate[:, 1] - 0.3, 3: 0.1 * RUN.up[:, 2]}
    pool = banded_design(small.blocks, small.readings, (shifted,), np.array([np.inf]))
    assert normal_equations(pool, NOISY).scale[0] == 0.0


def test_a_channel_that_was_not_recorded_is_left_out(small: Small) -> None:
    nothing = {channel: np.zeros(len(RUN.t)) for channel in (3, 4, 5)}
    pool = banded_design(with_weight(small.blocks, nothing), small.readings, COLUMNS, FREE)
    assert [channel is None for channel in pool.channels] == [False] * 3 + [True] * 3
    scale = normal_equations(pool, NOISY).scale
    assert (scale[:3] == 0).all()  # a lever arm is seen by accelerometers alone
    assert scale[3] > 0


def test_a_plausible_range_holds_what_the_readings_do_not_tell(small: Small) -> None:
    half = np.full(len(COLUMNS), 1e-9)
    state = normal_equations(replace(small.pool, half=half), NOISY)
    values = inverse(state.normal) @ state.right * state.scale
    assert np.abs(values).max() < 1e-9


def test_renewed_columns_and_readings_are_as_in_a_pool_built_anew(small: Small) -> None:
    other = {0: {c: 1.3 * series + 0.01 for c, series in COLUMNS[0].items()},
             9: {c: np.roll(series, 3) for c, series in COLUMNS[9].items()}}  # fmt: skip
    readings = small.readings + 1e-3 * RUN.up[:, [1, 2, 0, 2, 0, 1]] ** 2
    changed = with_columns(small.pool, other, readings)
    columns = [other.get(p, column) for p, column in enumerate(COLUMNS)]
    anew = banded_design(small.blocks, readings, columns, FREE)
    first, second = normal_equations(changed, NOISY), normal_equations(anew, NOISY)
    assert first.misfit == pytest.approx(second.misfit, rel=1e-5)
    np.testing.assert_allclose(first.scale, second.scale, rtol=1e-5)
    np.testing.assert_allclose(first.normal, second.normal, atol=1e-5)
    np.testing.assert_allclose(first.right, second.right, atol=1e-4 * abs(second.right).max())
    for one, two in zip(changed.columns, anew.columns, strict=True):
        assert set(one) == set(two)


def test_residuals_are_what_least_squares_leaves(small: Small) -> None:
    lever = [0, 1, 2]
    left = residuals(small.pool, lever, NOISY)
    for c in range(6):
        courses = [*regressors(RUN, c).T, *(COLUMNS[p][c] for p in lever if c in COLUMNS[p])]
        design = whitened(courses, small.pool, c, NOISY[c])
        target = whitened([small.readings[:, c]], small.pool, c, NOISY[c])[:, 0]
        size = np.linalg.norm(design, axis=0)
        values, *_ = np.linalg.lstsq(design / size, target, rcond=1e-12)
        level = np.repeat(NOISY[c].variance(small.pool.bands.frequency), small.pool.bands.sizes)
        direct = (target - design / size @ values) * np.sqrt(level)
        assert np.abs(left[c].coefficients - direct).max() < 1e-4 * np.sqrt(NOISY[c].white)


def test_the_noise_of_a_true_fit_is_that_which_was_made(small: Small) -> None:
    found = residual_noises(small.pool, [0, 1, 2], NOISY)
    full = [c for c in range(6) if c not in (0, 4)]  # the others weigh less
    white = np.array([found[c].white / NOISY[c].white for c in full])
    flicker = np.array([found[c].flicker / NOISY[c].flicker for c in full])
    assert np.abs(white - 1.0).max() < 0.05
    assert flicker.mean() == pytest.approx(1.0, abs=0.5)  # of 400 s


def test_the_generalised_inverse_leaves_what_nothing_determines_alone() -> None:
    column = np.random.default_rng(0).standard_normal((50, 2))
    design = np.column_stack([column, column.sum(axis=1), np.zeros(50)]) * [1e6, 1.0, 1.0, 1.0]
    normal = design.T @ design
    found = inverse(normal)
    assert np.isfinite(found).all()
    assert (found[3] == 0).all()
    size = np.sqrt(np.outer(np.diag(normal), np.diag(normal)))
    again = normal @ found @ normal
    assert np.abs(again - normal)[:3, :3].max() < 1e-6 * size.max()


@pytest.mark.parametrize("known", [1.0, 0.6, 0.25])
def test_the_noise_of_the_rows_that_are_known_is_that_of_all(known: float) -> None:
    """A motion that labels alone tell is known in a part of the rows; the rest are zeros there."""
    count = len(RUN.t)
    weight = np.zeros((count, 6))
    weight[np.arange(count) % 400 < 400 * known] = 1.0
    blocks = replace(observed(noise(count, 11), RUN), weight=weight)
    design = banded_design(blocks, blocks.readings, (), np.zeros(0))
    for found, true in zip(initial_noises(design), QUIET, strict=True):
        assert found.white == pytest.approx(true.white, rel=0.1)
