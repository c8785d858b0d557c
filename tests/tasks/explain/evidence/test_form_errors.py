"""A name stands only where its evidence is more than the forms of everything else may leave."""

from dataclasses import replace

import numpy as np
import pytest

from tasks.explain.evidence.form_errors import named_beside
from tasks.explain.explanation import UNNAMED, Finding
from tasks.explain.odds import CERTAIN, PUBLISHED, UNPUBLISHED

NOISE, NOTHING = np.ones(6), np.zeros(6)
EVERYWHERE = np.ones((1000, 6))
NAMED = Finding(
    effect="lever_arm", family="geometry", title="lever arm", equation="", source="",
    channels=(3, 4), parameters=(), contribution=EVERYWHERE * [0, 0, 0, 1, 1, 0],
    gain=60.0, delta_bic=50.0, held_out_gain=30.0, indistinguishable=("size_effect",),
    behaviour="the angular acceleration",
)  # fmt: skip
STRONG = replace(NAMED, effect="accel_nonlinearity", gain=9000.0, delta_bic=8900.0)


def names(*findings: Finding, left: np.ndarray = NOTHING, **more: object) -> list[str]:
    return [one.effect for one in named_beside(findings, (), left, NOISE, **more)]  # type: ignore[arg-type]


def test_a_weak_name_alone_or_beside_its_like_stands() -> None:
    assert names(NAMED) == ["lever_arm"]
    assert names(NAMED, replace(NAMED, effect="bias_step")) == ["lever_arm", "bias_step"]


def test_a_weak_name_beside_something_far_stronger_is_an_error_of_its_form() -> None:
    lost, kept = named_beside([NAMED, STRONG], (), NOTHING, NOISE)
    assert kept is STRONG
    assert (lost.effect, lost.title) == (UNNAMED, "the angular acceleration")
    assert lost.indistinguishable == ()
    assert lost.refusal is not None
    assert (lost.refusal.kind, lost.refusal.name) == ("form_error", "lever_arm")
    assert lost.refusal.value == pytest.approx(150.0)


def test_what_acts_on_other_channels_leaves_nothing_in_these() -> None:
    gyros = replace(STRONG, channels=(0,), contribution=EVERYWHERE * [1, 0, 0, 0, 0, 0])
    assert names(NAMED, gyros) == ["lever_arm", "accel_nonlinearity"]


def test_what_was_put_right_first_leaves_form_errors_too() -> None:
    (lost,) = named_beside([NAMED], [replace(STRONG, effect="code_fault")], NOTHING, NOISE)
    assert lost.effect == UNNAMED


def test_what_has_no_name_leaves_more_than_a_published_equation() -> None:
    other = replace(STRONG, gain=1000.0)
    assert names(NAMED, other)[0] == "lever_arm"
    assert names(NAMED, replace(other, effect=UNNAMED))[0] == UNNAMED


def test_beside_what_nothing_explains_in_its_channels_a_weak_name_is_withdrawn() -> None:
    left = np.array([0.0, 0.0, 0.0, 600.0, 0.0, 0.0])
    (lost,) = named_beside([NAMED], (), left, NOISE)
    assert lost.refusal is not None
    assert (lost.refusal.kind, lost.refusal.value) == ("overshadowed", pytest.approx(10.0))
    assert names(replace(NAMED, gain=6000.0, delta_bic=5990.0), left=left) == ["lever_arm"]
    assert names(NAMED, left=np.roll(left, 3)) == ["lever_arm"]


def test_what_every_model_contains_is_no_form_error_but_may_be_overshadowed() -> None:
    frame = replace(NAMED, effect="reference_frame")
    assert names(frame, STRONG)[0] == UNNAMED
    assert names(frame, STRONG, nuisances=("reference_frame",))[0] == "reference_frame"
    left = np.full(6, 600.0)
    assert names(frame, left=left, nuisances=("reference_frame",)) == [UNNAMED]


def test_physics_that_is_known_beforehand_keeps_its_name() -> None:
    assert names(replace(NAMED, behaviour=""), STRONG, left=np.full(6, 1e5))[0] == "lever_arm"


@pytest.mark.parametrize(
    ("form", "strong"), [(PUBLISHED, STRONG), (UNPUBLISHED, replace(STRONG, effect=UNNAMED))]
)
def test_a_form_error_of_the_stated_size_gets_a_name_in_one_of_a_hundred(
    form: float, strong: Finding
) -> None:
    """Of an effect that is not there, fitted to noise and to what the form of a strong one lacks:
    its gain is the square of a normal variable with the variance 1 + τ²·g.
    """
    rng = np.random.default_rng(7)
    sizes = rng.standard_normal(400) * np.sqrt(1.0 + form**2 * strong.gain)
    weak = [replace(NAMED, gain=size**2, delta_bic=size**2) for size in sizes.tolist()]
    named = sum(names(one, strong)[0] != UNNAMED for one in weak)
    assert named <= 0.01 * len(weak)  # 2·ln 99 of a normal variable is exceeded by 0.0024
    assert pytest.approx(2.0 * np.log(99.0), abs=0.02) == CERTAIN
