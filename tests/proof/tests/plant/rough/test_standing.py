"""How far an effect stands above all else counts its own signature alone."""

import pytest

from tests.proof.plant.rough.play import play, standing, without
from tests.proof.tests.plant.rough.short_runs import rough_of


@pytest.mark.parametrize("form", ["vibration_rectification", "vibration_rectification_speed"])
def test_shaking_is_what_rectification_stands_above_and_no_part_of_it(form: str) -> None:
    rough = rough_of("shaft", form)
    rest = play(without(rough, form))
    once, twice = (standing(play(rough.with_strength(form, k)), rest) for k in (1.0, 2.0))
    assert standing(play(rough.with_strength(form, 0.0)), rest) == 0.0
    assert 0.0 < once < standing(play(rough), play(rough.without(form)))
    assert 1.5 * once < twice < 2.5 * once  # codes round what is small


def test_what_does_not_shake_is_gone_without_it() -> None:
    rough = rough_of("shaft", "bias_step_single")
    assert not without(rough, "bias_step_single").case.effects
