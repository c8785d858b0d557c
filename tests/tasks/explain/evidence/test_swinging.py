"""A mount that swings is not said to be a filter of the accelerometers."""

import numpy as np
import pytest
from engine_run import NOISY, RATE, motion, noise, observed, read
from scipy.fft import irfft, rfft, rfftfreq

from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.scrutiny import Scrutiny
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.design import NormalEquations
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.stepwise import Selected, Selection
from tasks.model.terms.electronics import BANDWIDTH_BY_TRIAD

RUN = motion()


def refusal_of_filter(readings: np.ndarray) -> str | None:
    """Why the readings, with noise, do not show a low-pass of each triad; nothing if they do."""
    made = readings + noise(len(RUN.t), 71, NOISY)
    chosen = (Selected(Candidate(BANDWIDTH_BY_TRIAD, (0, 1), (0, 1), 1), 100.0, 90.0, ()),)
    nothing = NormalEquations(np.zeros((0, 0)), np.zeros(0), np.zeros(0), 0.0)
    selection = Selection(chosen, NOISY, 0.0, nothing)
    evidence = Evidence.of(FittedSelection.of(selection, observed(made, RUN), RATE))
    refusal = Scrutiny.of(evidence, 0).refusal
    return refusal and refusal.kind


def on_rubber(frequency: float, damping: float, share: float) -> np.ndarray:
    """Readings (n, 6) of accelerometers that feel a share of a resonance of the specific force."""
    made = read(RUN)
    ratio = rfftfreq(2 * len(made), 1.0 / RATE) / frequency
    excess = 1.0 / (1.0 - ratio**2 + 2j * damping * ratio) - 1.0
    mirrored = np.concatenate([made[:, 3:], made[::-1, 3:]])
    swung = irfft(excess[:, None] * rfft(mirrored, axis=0), axis=0)[: len(made)]
    made[:, 3:] += share * swung
    return made


@pytest.mark.parametrize(("frequency", "damping"), [(7.0, 0.1), (9.0, 0.06), (12.0, 0.15)])
def test_a_mount_that_swings_is_no_filter(frequency: float, damping: float) -> None:
    assert refusal_of_filter(on_rubber(frequency, damping, 1.3)) == "swings"


@pytest.mark.parametrize("seconds", [0.003, 0.008])
def test_a_filter_of_the_accelerometers_keeps_its_name(seconds: float) -> None:
    assert refusal_of_filter(read(RUN, (BANDWIDTH_BY_TRIAD, (0.0, seconds)))) is None


def test_a_filter_of_both_triads_is_not_questioned() -> None:
    assert refusal_of_filter(read(RUN, (BANDWIDTH_BY_TRIAD, (0.006, 0.006)))) is None
