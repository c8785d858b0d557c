"""Of names that fit as well, the special case and what a unit may have stand first."""

from dataclasses import replace

import numpy as np
import pytest
from engine_run import NOISY, motion, noise, observed, read

from tasks.explain.evidence.confounding import with_preferred
from tasks.explain.explanation import UNNAMED
from tasks.explain.search.candidates import Candidate, columns_of
from tasks.explain.search.design import banded_design
from tasks.explain.search.empirical import empirical
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.stepwise import Selected, search
from tasks.model.term import Term
from tasks.model.terms.environment import TEMPERATURE_BIAS, THERMAL_GRADIENT
from tasks.model.terms.geometry import LEVER_ARM, SIZE_EFFECT
from tasks.model.terms.site import earth_rotation
from tasks.motion.whole import Motion

RUN, EARTH = motion(), earth_rotation(0.7)
NINE_FACTORS = next(term for term in empirical(RUN) if term.equation == "reading += c·ω̇")


def found_as(
    made: np.ndarray, run: Motion, first: Term, second: Term
) -> tuple[FittedSelection, list[Candidate]]:
    """Readings (n, 6) found as the first of two terms, the second as likely."""
    blocks, of_each = observed(made, run), [columns_of(term, run) for term in (first, second)]
    own, others = (tuple(range(len(columns))) for columns in of_each)
    whole = [
        Candidate(first, own, own, 1),
        Candidate(second, tuple(len(own) + k for k in others), others, 1),
    ]
    columns = [column for each in of_each for column in each]
    design = banded_design(blocks, made, columns, np.full(len(columns), np.inf))
    selection = search(design, whole, (), NOISY)
    selection = replace(selection, selected=(Selected(whole[0], 1.0, 1.0, (second.name,)),))
    return FittedSelection.of(selection, blocks, blocks.rate), whole


def preferred(
    made: np.ndarray, run: Motion, first: Term, second: Term
) -> tuple[str, tuple[str, ...]]:
    fit, candidates = found_as(made, run, first, second)
    (one,) = with_preferred(fit, candidates).selection.selected
    return one.candidate.name, one.rivals


def test_a_lever_arm_stands_before_the_size_effect_that_holds_it() -> None:
    arm = read(RUN, (LEVER_ARM, (0.012, -0.018, 0.007))) + noise(len(RUN.t), 5, NOISY)
    assert preferred(arm, RUN, SIZE_EFFECT, LEVER_ARM) == ("lever_arm", ("size_effect",))
    assert preferred(arm, RUN, LEVER_ARM, SIZE_EFFECT) == ("lever_arm", ("size_effect",))


@pytest.mark.parametrize("arm", [(0.012, -0.018, 0.007), (0.0, 0.0, 0.03), (-0.0004, 0.05, 0.0)])
def test_a_lever_arm_stands_before_nine_factors_of_the_angular_acceleration(
    arm: tuple[float, ...],
) -> None:
    made = read(RUN, (LEVER_ARM, arm)) + noise(len(RUN.t), 7, NOISY)
    assert preferred(made, RUN, NINE_FACTORS, LEVER_ARM)[0] == "lever_arm"


@pytest.mark.parametrize(("off", "name"), [(0.04, "lever_arm"), (0.4, UNNAMED)])
def test_a_lever_arm_stands_where_factors_are_off_its_own_by_no_more_than_forms_are(
    off: float, name: str
) -> None:
    """A lever arm of 3 m/s² in 0.01, and one factor that is off by a share of its own."""
    made = read(RUN, (LEVER_ARM, (0.12, -0.18, 0.07))) + noise(len(RUN.t), 7, NOISY)
    made[:, 3] += off * 0.18 * RUN.acceleration[:, 2]
    assert preferred(made, RUN, NINE_FACTORS, LEVER_ARM)[0] == name


@pytest.mark.parametrize("entry", [(0, 0), (0, 1), (2, 1)])
def test_factors_of_the_angular_acceleration_that_no_place_has_are_no_lever_arm(
    entry: tuple[int, int],
) -> None:
    made = read(RUN) + noise(len(RUN.t), 7, NOISY)
    made[:, 3 + entry[0]] += 0.02 * RUN.acceleration[:, entry[1]]
    assert preferred(made, RUN, NINE_FACTORS, LEVER_ARM)[0] == UNNAMED


def test_accelerometers_that_are_apart_are_no_lever_arm() -> None:
    places = np.array([[0.03, 0.0, 0.0], [0.0, -0.02, 0.0], [0.01, 0.02, 0.0]]).ravel()
    apart = read(RUN, (SIZE_EFFECT, places)) + noise(len(RUN.t), 5, NOISY)
    assert preferred(apart, RUN, SIZE_EFFECT, LEVER_ARM)[0] == "size_effect"


def test_what_is_not_plausible_gives_way_to_what_fits_as_well_and_is() -> None:
    """A temperature that approaches its end exponentially, and accelerometers that follow it: so
    they follow its rate as well, with a coefficient that no unit has.
    """
    fading = np.exp(-RUN.t / 150.0)
    temperature = {"temperature": 25.0 - fading, "temperature_rate": fading / 150.0}
    warming = replace(RUN, recorded={**RUN.recorded, **temperature})
    made = read(warming, (TEMPERATURE_BIAS, (0.0, 0.0, 0.0, 0.08, 0.08, 0.08)))
    made = made + noise(len(RUN.t), 4, NOISY)
    assert preferred(made, warming, THERMAL_GRADIENT, TEMPERATURE_BIAS)[0] == "temperature_bias"
    assert preferred(made, warming, TEMPERATURE_BIAS, THERMAL_GRADIENT)[0] == "temperature_bias"


def test_known_physics_has_no_parameter_that_might_be_implausible() -> None:
    earth = read(RUN, (EARTH, ())) + noise(len(RUN.t), 6, NOISY)
    assert preferred(earth, RUN, EARTH, LEVER_ARM)[0] == "earth_rotation"
