"""A name stands only where what it removes is not small beside what else there is."""

from dataclasses import replace

import numpy as np
import pytest

from schemas.discrepancy import FoundParameter
from tasks.explain.evidence.left_over import LeftOver
from tasks.explain.evidence.shares import (
    CHANCE,
    chance_of_largest,
    without_form_errors,
    without_shadows,
    without_slivers,
)
from tasks.explain.explanation import UNNAMED, Finding

ROWS = 1000
NAMED = Finding(
    effect="lever_arm", family="geometry", title="lever arm", equation="", source="",
    channels=(3, 4), parameters=(FoundParameter(name="r_x", value=0.1, u=0.01, unit="m"),),
    contribution=np.zeros((ROWS, 6)), gain=900.0, delta_bic=880.0,
    held_out_gain=400.0, indistinguishable=("size_effect",), behaviour="the angular acceleration",
)  # fmt: skip


def left(chi2: float, channel: int) -> LeftOver:
    after = np.ones((ROWS, 6))
    after[:, channel] = chi2
    none = np.zeros((ROWS, 6), bool)
    return LeftOver(after, after, none, np.ones((ROWS, 6)), np.zeros((ROWS, 6)), 1)


def test_beside_ten_times_as_much_in_its_channels_a_name_is_withdrawn() -> None:
    clear = replace(NAMED, delta_bic=1100.0)
    (shadow,) = without_shadows([clear], [900.0], left(10.1, 3))
    assert shadow.effect == UNNAMED
    assert shadow.title == "the angular acceleration"
    assert shadow.indistinguishable == ()
    assert shadow.refusal is not None
    assert (shadow.refusal.kind, shadow.refusal.name) == ("overshadowed", "lever_arm")
    assert shadow.refusal.value is not None
    assert round(shadow.refusal.value) == 10


def test_what_is_left_in_other_channels_takes_no_name_away() -> None:
    assert without_shadows([NAMED], [900.0], left(10.1, 0)) == [NAMED]


def test_most_of_a_mismatch_keeps_its_name_though_something_is_left() -> None:
    clear = replace(NAMED, delta_bic=1100.0)
    assert without_shadows([clear], [9000.0], left(10.1, 3)) == [clear]


def test_weak_evidence_beside_what_nothing_explains_gives_no_name() -> None:
    weak = replace(NAMED, delta_bic=150.0)
    assert without_shadows([weak], [9000.0], left(1.3, 3)) == [weak]
    assert without_shadows([weak], [9000.0], left(10.1, 3), {"lever_arm"}) == [weak]
    (unnamed,) = without_shadows([weak], [9000.0], left(2.0, 3))
    assert unnamed.effect == UNNAMED
    assert unnamed.refusal is not None
    assert (unnamed.refusal.kind, unnamed.refusal.value) == ("incomplete", pytest.approx(2.0))


def test_a_random_drift_has_a_name_only_where_nothing_else_is_left() -> None:
    drift = replace(NAMED, effect="bias_random_walk", parameters=())
    assert without_shadows([drift], [9000.0], left(1.2, 3)) == [drift]
    assert without_shadows([drift], [9000.0], left(10.1, 0)) == [drift]
    (other,) = without_shadows([drift], [90000.0], left(2.7, 3))
    assert other.effect == UNNAMED
    assert other.refusal is not None
    assert (other.refusal.kind, other.refusal.value) == ("incomplete", pytest.approx(2.7))


def test_physics_that_is_known_beforehand_is_no_shadow() -> None:
    known = replace(NAMED, behaviour="")
    assert without_shadows([known], [1.0], left(10.1, 3)) == [known]


def test_a_weak_name_beside_something_far_stronger_is_its_form_error() -> None:
    weak, strong = replace(NAMED, gain=60.0, delta_bic=50.0), replace(NAMED, gain=9000.0)
    form_error, kept = without_form_errors([weak, strong])
    assert kept == strong
    assert form_error.effect == UNNAMED
    assert form_error.refusal is not None
    assert (form_error.refusal.kind, form_error.refusal.value) == ("form_error", 150.0)


def test_a_weak_name_alone_or_beside_its_like_stands() -> None:
    weak = replace(NAMED, gain=60.0, delta_bic=50.0)
    assert without_form_errors([weak, NAMED]) == [weak, NAMED]


def test_what_removes_less_than_a_form_may_leave_has_no_name_whatever_its_evidence() -> None:
    arm = replace(NAMED, share=0.94, terms=(("lever_arm", ()),))
    ripple = replace(arm, effect="rate_ripple", share=0.009, delta_bic=1e4)
    kept, sliver = without_slivers([arm, ripple], ())
    assert kept == arm
    assert sliver.effect == UNNAMED
    assert sliver.refusal is not None
    assert sliver.refusal.value == pytest.approx(1.0 / 0.009)
    for one in (replace(ripple, share=0.011), replace(ripple, terms=())):
        assert without_slivers([arm, one], ()) == [arm, one]


def test_what_every_model_contains_hides_no_other_effect() -> None:
    frame = replace(NAMED, effect="reference_frame", share=0.98, terms=(("reference_frame", ()),))
    weak = replace(frame, effect="temperature_bias", share=0.009)
    assert without_slivers([frame, weak], ("reference_frame",)) == [frame, weak]
    assert without_slivers([replace(frame, share=0.001)], ("reference_frame",))[0].effect != UNNAMED


def test_what_every_model_contains_is_no_form_error_of_what_is_beside_it() -> None:
    frame = replace(NAMED, effect="reference_frame", gain=60.0, delta_bic=50.0)
    strong = replace(NAMED, gain=9000.0)
    assert without_form_errors([frame, strong], (), ("reference_frame",)) == [frame, strong]
    assert without_form_errors([frame, strong])[0].effect == UNNAMED


def test_a_drift_is_the_form_error_of_a_stronger_memory_in_its_channels_only() -> None:
    memory = replace(NAMED, effect="hysteresis", channels=(0, 2), gain=640.0)
    drift = replace(NAMED, effect="bias_random_walk", channels=(0,), gain=430.0, parameters=())
    form_error, kept = without_form_errors([drift, memory])
    assert kept == memory
    assert form_error.refusal is not None
    assert form_error.refusal.kind == "form_error"
    assert form_error.refusal.value == pytest.approx(640.0 / 430.0)
    for other in (replace(drift, channels=(1,)), replace(drift, gain=700.0)):
        assert without_form_errors([other, memory]) == [other, memory]
    step = replace(memory, effect="bias_step")
    assert without_form_errors([drift, step]) == [drift, step]


@pytest.mark.parametrize("fault", ["dead_zone", "code_fault"])
def test_a_drift_of_readings_that_were_put_right_is_no_random_walk(fault: str) -> None:
    drift = replace(NAMED, effect="bias_random_walk", channels=(0,), gain=430.0, parameters=())
    put_right = replace(NAMED, effect=fault, channels=(0, 1, 2), gain=2e4)
    (form_error,) = without_form_errors([drift], [put_right])
    assert form_error.effect == UNNAMED
    elsewhere = replace(drift, channels=(4,))
    assert without_form_errors([elsewhere], [put_right]) == [elsewhere]


def test_what_was_put_right_first_leaves_form_errors_too() -> None:
    weak = replace(NAMED, gain=60.0, delta_bic=50.0)
    (form_error,) = without_form_errors([weak], [replace(NAMED, effect="code_fault", gain=2e4)])
    assert form_error.effect == UNNAMED


def test_walks_are_said_to_switch_as_seldom_as_stated() -> None:
    rng = np.random.default_rng(17)
    walks = np.cumsum(rng.standard_normal((2000, 400)), axis=1)
    switching = sum(chance_of_largest(walk) < CHANCE for walk in walks)
    assert switching <= CHANCE * len(walks) + 3.0 * np.sqrt(CHANCE * len(walks))


def test_a_signal_that_switches_there_and_back_is_no_walk() -> None:
    t = np.linspace(0.0, 100.0, 5000)
    switched = np.where((t > 36.8) & (t < 61.3), 1.0, 0.0)
    assert chance_of_largest(switched) < 1e-6
    wander = 0.05 * np.cumsum(np.random.default_rng(3).standard_normal(5000)) / np.sqrt(250.0)
    assert chance_of_largest(switched + wander) < CHANCE


def test_what_does_not_change_or_is_hardly_known_is_not_judged() -> None:
    assert chance_of_largest(np.zeros(100)) == 1.0
    assert chance_of_largest(np.full(100, np.nan)) == 1.0
