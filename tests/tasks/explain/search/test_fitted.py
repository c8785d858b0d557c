"""Effects that are asked for are fitted, and nothing else, beside the noise that they leave."""

from functools import cache

import numpy as np
import pytest
from short_run import RATE, ShortRun, short_run

from tasks.explain.explain import fitted_effects
from tasks.explain.search.fitted import FittedSelection
from tests.proof.plant.case import channel_noise

SEEDS = (5, 6, 7)
FLICKER = np.array(
    [noise.instability**2 / (2.0 * np.pi) * RATE / 2.0 for noise in channel_noise("industrial")]
)
Z = 60.0
NAME = "accel_nonlinearity"
TRUE = np.array([1e-4, -2e-4, 1e-4])  # of g


def signal(run: ShortRun) -> np.ndarray:
    """It changes from dwell to dwell: slowly, as flicker does."""
    return np.hstack([np.zeros_like(run.force), TRUE * run.force**2 / 9.8])


@cache
def bent(seed: int) -> FittedSelection:
    run = short_run(seed)
    return fitted_effects(run.with_signal(signal(run), Z), [NAME])


def flicker(fit: FittedSelection) -> np.ndarray:
    return np.array([noise.flicker for noise in fit.noises])


def test_nothing_is_fitted_that_was_not_asked_for() -> None:
    assert {one.name for one in bent(5).selection.candidates} == {NAME}


@pytest.mark.rehearsal
def test_what_an_effect_reads_is_not_taken_for_noise() -> None:
    """Flicker looks the same without the effect and with it, and is that of the unit."""
    for seed in SEEDS[:2]:
        run = short_run(seed)
        clean = flicker(fitted_effects(run.recording, [NAME]))
        assert np.all(flicker(bent(seed)) < 2.0 * clean)
    ratios = np.array([flicker(bent(seed)) / FLICKER for seed in SEEDS])
    middle = np.exp(np.log(ratios).mean(axis=0))
    assert np.all((middle > 0.4) & (middle < 2.5))


@pytest.mark.rehearsal
def test_the_uncertainty_of_what_was_asked_for_is_that_of_its_errors() -> None:
    errors = []
    for seed in SEEDS:
        run, fit = short_run(seed), bent(seed)
        place = next(own for key, own in fit.model.places.items() if key[0] == NAME)
        true = TRUE * (Z / run.z(signal(run)))
        errors.append((fit.model.values[place] - true) / fit.model.u[place])
    assert 0.4 < np.mean(np.square(errors)) < 2.0  # of 9


@pytest.mark.rehearsal
@pytest.mark.parametrize("share", [0.25, 0.6])
def test_a_step_is_found_wherever_it_is(share: float) -> None:
    run = short_run(5)
    at = share * float(run.t[-1])
    step = np.outer(run.t > at, [1e-4, 1e-4, 1e-4, 1e-2, 1e-2, 1e-2])
    fit = fitted_effects(run.with_signal(step, 15.0), ["bias_step"])
    (term,) = (one for one in fit.model.terms if one.name == "bias_step")
    assert term.at[0] == pytest.approx(at, abs=5.0)
