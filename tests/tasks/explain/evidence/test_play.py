"""A unit that tips over is not said to bend, and one that bends is not said to tip over."""

from dataclasses import replace

import numpy as np
import pytest
from engine_run import NOISY, RATE, motion, noise, observed, read

from tasks.explain.evidence.confounding import TILTING, with_play
from tasks.explain.search.candidates import Candidate, columns_of
from tasks.explain.search.design import banded_design
from tasks.explain.search.empirical import Tip, tips
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.stepwise import search
from tasks.model.term import Column
from tasks.model.terms.geometry import SAG

RUN = motion()
ANGLE = np.array([6e-4, -9e-4, 5e-4])


def bent(readings: np.ndarray) -> tuple[FittedSelection, list[Candidate]]:
    """Readings of the run to which a fixture that sags was fitted."""
    blocks = observed(readings, RUN)
    columns: list[Column] = []
    candidates: list[Candidate] = []
    for variant, term in enumerate((SAG, *tips())):
        own = tuple(range(len(term.parameters)))
        members = tuple(len(columns) + q for q in own)
        candidates.append(Candidate(replace(term, variant=variant), members, own, 1))
        columns += columns_of(term, RUN)
    design = banded_design(blocks, readings, columns, np.full(len(columns), np.inf))
    selection = search(design, candidates, candidates[:1], NOISY)
    found = tuple(one for one in selection.selected if one.candidate is candidates[0])
    return FittedSelection.of(replace(selection, selected=found), blocks, RATE), candidates


@pytest.mark.parametrize("direction", [(0.9, 0.1, -0.4), (-0.3, 0.8, 0.5)])
def test_a_unit_that_tips_over_has_no_fixture_that_bends(direction: tuple[float, ...]) -> None:
    made = read(RUN, (Tip.along(np.array(direction)), ANGLE)) + noise(len(RUN.t), 61, NOISY)
    found = with_play(*bent(made))
    (tip,) = [term for term in found.model.terms if isinstance(term, Tip)]
    assert not [term for term in found.model.terms if term.name in TILTING]
    unit = np.array(direction) / np.linalg.norm(direction)
    assert abs(tip.direction @ unit) > np.cos(0.15)
    values = found.model.values[found.model.places[tip.key]]
    np.testing.assert_allclose(np.sign(tip.direction @ unit) * values, ANGLE, atol=1e-4)


def test_a_fixture_that_bends_keeps_its_name() -> None:
    size = 1e-4 * np.random.default_rng(3).standard_normal(9) * (1.0 - np.eye(3)).ravel()
    fit, candidates = bent(read(RUN, (SAG, size)) + noise(len(RUN.t), 62, NOISY))
    assert with_play(fit, candidates) is fit
