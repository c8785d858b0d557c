"""A dead band is told by the rates that it takes off, not by what errs at rests."""

from dataclasses import replace

import numpy as np
import pytest
from engine_run import NOISY, RATE, motion, noise, observed, read

from tasks.explain.evidence.dead_band import unseen_turning
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.explanation import Refusal
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.design import NormalEquations
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.stepwise import Selected, Selection
from tasks.model.terms.gyro import gyro_dead_band
from tasks.motion.whole import Motion

RUN = motion()
BAND = gyro_dead_band(0.02)


def refused(made: np.ndarray, reported: Motion) -> Refusal | None:
    """Why a dead band fitted to readings (n, 6) beside what the reference told has no name."""
    selected = Selected(Candidate(BAND, (0, 1, 2), (0, 1, 2), 1), 100.0, 90.0, ())
    nothing = NormalEquations(np.zeros((0, 0)), np.zeros(0), np.zeros(0), 0.0)
    blocks = replace(observed(made, RUN), motion=reported)
    fit = FittedSelection.of(Selection((selected,), NOISY, 0.0, nothing), blocks, RATE)
    return unseen_turning(Evidence.of(fit), 0)


def test_one_that_takes_off_faster_rates_too_keeps_its_name() -> None:
    made = read(RUN, (BAND, [-1.0, -0.5, -0.8])) + noise(len(RUN.t), 61, NOISY)
    assert refused(made, RUN) is None


@pytest.mark.parametrize("error", [2e-3, 0.02])  # rad/s, now and then as fast as a turn
def test_what_takes_off_the_errors_of_rests_alone_has_no_name(error: float) -> None:
    resting = ~RUN.rate.any(axis=1, keepdims=True)
    errors = error * np.random.default_rng(62).standard_t(2.0, RUN.rate.shape)
    reported = replace(RUN, rate=RUN.rate + resting * errors)
    refusal = refused(read(RUN) + noise(len(RUN.t), 61, NOISY), reported)
    assert refusal is not None
    assert refusal.kind == "undetermined"
