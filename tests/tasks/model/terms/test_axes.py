"""Tilt, axes out of square and wobble, against attitudes written out."""

from dataclasses import replace

import numpy as np
import pytest

from tasks.model.term import Term
from tasks.model.terms.axes import AXIS_TILT, axis_nonorthogonality, axis_wobble, candidates
from tests.tasks.model.table_run import (
    ANGLES,
    DIRECTIONS,
    EAST,
    HEADED,
    NORTH,
    T,
    attitude,
    felt,
    motion,
    read,
    recording,
    undisturbed,
)

INSIDE = slice(2, -2)
BLIND = replace(motion(), north=np.full((len(T), 3), np.nan))


def added(term: Term, values: list[float], between: dict) -> tuple[np.ndarray, np.ndarray]:
    """What a term adds, and what the attitudes say."""
    return (
        (read((term,), values) - read((), []))[INSIDE],
        (felt(attitude(between=between)) - undisturbed())[INSIDE],
    )


def test_a_base_out_of_level_turns_all_about_east_and_north():
    east, north = 2e-4, -1e-4
    term, real = added(AXIS_TILT, [east, north], {-1: east * EAST + north * NORTH})
    assert term == pytest.approx(real, abs=1e-6)
    assert np.abs(term[:, 3:]).max() > 1e-3
    assert not term[:, :3].any()


def test_without_a_heading_the_tilt_is_about_the_tables_own_axes():
    turn = 2e-4 * EAST - 1e-4 * NORTH
    term = read((AXIS_TILT,), [2e-4, -1e-4], BLIND) - read((), [], BLIND)
    real = felt(attitude(between={-1: HEADED[0] @ turn})) - undisturbed()
    assert term[INSIDE, 3:] == pytest.approx(real[INSIDE, 3:], abs=1e-6)


def test_axes_out_of_square_turn_about_their_common_normal():
    first, second = 2e-4, -3e-4
    normals = np.cross(DIRECTIONS[:-1], DIRECTIONS[1:])
    term, real = added(
        axis_nonorthogonality((0, 1)), [first, second],
        {0: first * normals[0], 1: second * normals[1]},
    )  # fmt: skip
    assert term == pytest.approx(real, abs=1e-6)
    assert np.abs(term).max(axis=0).min() > 1e-5


@pytest.mark.parametrize("m", [1, 2])
def test_an_axis_that_wobbles_leans_with_its_angle(m):
    values = 1e-4 * np.array([1.0, -2.0, 0.5, 1.5])  # East sine, cosine; North sine, cosine
    phase = m * ANGLES[:, :1]
    waves = np.hstack([np.sin(phase), np.cos(phase)])
    lean = (waves @ values[:2])[:, None] * EAST + (waves @ values[2:])[:, None] * NORTH
    term, real = added(axis_wobble(m), list(values), {-1: lean})
    assert term == pytest.approx(real, abs=1e-6)
    assert np.abs(term).max(axis=0).min() > 1e-5


def test_only_an_upright_first_axis_is_said_to_wobble():
    run = motion()
    lying = replace(run, up=np.cross(run.north, run.up), north=run.north)
    assert "axis_wobble" in {term.name for term in candidates(recording(), run)}
    assert "axis_wobble" not in {term.name for term in candidates(recording(), lying)}


def test_parallel_axes_have_no_angle_between_them():
    run = motion()
    assert run.axes is not None
    twice = run.axes.directions.copy()
    twice[:, 1] = twice[:, 0]
    parallel = replace(run, axes=replace(run.axes, directions=twice))
    found = {term.name: term for term in candidates(recording(), parallel)}
    assert [p.name for p in found["axis_nonorthogonality"].parameters] == ["angle_2"]
