"""What a recording cannot tell apart is named beside what was selected, and nothing else is."""

import numpy as np
import pytest
from engine_run import NOISY, motion, noise, observed, read
from labelled_rests import labelled_rests, recording_of

from schemas.recording import Recording
from tasks.explain.explain import explain
from tasks.explain.search.candidates import candidates_of, plausible_half_ranges
from tasks.explain.search.design import banded_design
from tasks.explain.search.rivals import with_rivals
from tasks.explain.search.stepwise import Selection, search
from tasks.model.term import Term
from tasks.model.terms.environment import TEMPERATURE_BIAS
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.site import earth_rotation
from tasks.model.terms.timing import TIME_OFFSET

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
