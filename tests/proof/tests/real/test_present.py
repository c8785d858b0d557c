"""What the hand analyses find in the real recordings is there, and two ways agree on it."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from schemas.recording import Recording
from tests.proof.real.cases import BY_HAND, untouched
from tests.proof.real.fact import Answer, Fact, Recordings
from tests.proof.real.hand.rate_table import ripple, together, waves_per_turn
from tests.proof.real.hand.rests import half_difference, means_of, misfit, vertical_earth_rate
from tests.proof.real.hand.shaft import corner, delay_by_angle, delay_by_gravity, delay_by_phase
from tests.proof.real.hide import TRANSFORMATIONS, Size
from tests.proof.real.on_rate_table import FIRST, SECOND
from tests.proof.real.on_shaft import SHAFT
from tests.proof.real.present import RECORDINGS, doubtful, facts_of

Real = Callable[[str], Recording]


@pytest.fixture(scope="module")
def recordings(real: Real) -> Recordings:
    return {name: real(name) for name in RECORDINGS}


@pytest.fixture(scope="module")
def facts(recordings: Recordings) -> dict[str, Fact]:
    return {each.key: each for each in facts_of(recordings)}


def test_ring_laser_unit_sees_earth_turn_at_its_latitude(recordings: Recordings) -> None:
    recording = recordings["ln100_two_position"]
    observation, known = half_difference(recording, 0), vertical_earth_rate(recording)
    assert observation.agrees(known)
    assert observation.u < 0.05


def test_mems_unit_does_not(recordings: Recordings) -> None:
    recording = recordings["adi_mems_two_position"]
    assert not half_difference(recording, 0).agrees(vertical_earth_rate(recording))


def test_gyro_on_the_shaft_is_twelve_milliseconds_late_in_two_ways(recordings: Recordings) -> None:
    by_angle, by_phase = (way(recordings[SHAFT]) for way in (delay_by_angle, delay_by_phase))
    assert by_angle.agrees(by_phase)
    assert by_angle.value == pytest.approx(0.012, abs=3e-4)
    assert delay_by_gravity(recordings[SHAFT]).value < by_angle.value - 0.002


def test_its_low_pass_is_near_the_makers(recordings: Recordings) -> None:
    assert 33.0 < corner(recordings[SHAFT]).value < 46.0


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("time_offset", Size(0.003, "s")),
        ("time_offset", Size(0.034, "s")),
        ("table_scale", Size(0.01, "1")),
        ("dropped_samples", Size(4.0, "1", at=30.0)),
    ],
)
def test_what_is_hidden_is_there_by_hand(shared_real: Path, name: str, size: Size) -> None:
    before = untouched(shared_real, SHAFT)
    after = TRANSFORMATIONS[name](before, size)
    found = BY_HAND[name](after, size).value - BY_HAND[name](before, size).value
    hidden = 0.04 if name == "dropped_samples" else size.value
    assert found == pytest.approx(hidden, rel=0.05)


def test_both_units_see_one_table_ripple_forty_eight_times_a_turn(recordings: Recordings) -> None:
    one, other = recordings[FIRST], recordings[SECOND]
    assert waves_per_turn(one).value == pytest.approx(48.0, abs=0.02)
    assert waves_per_turn(other).value == pytest.approx(48.0, abs=0.02)
    assert ripple(one, 48.0, 30.0).agrees(ripple(other, 48.0, 30.0))
    assert together(one, other, 48.0) > 0.99


def test_only_exchanged_z_rests_fit_bias_and_matrix(recordings: Recordings) -> None:
    directions, mine = means_of(recordings[FIRST])
    _, theirs = means_of(recordings[SECOND])
    for axis in range(3):
        turned = (np.abs(directions[:, axis]) > 0)[:, None]
        left = misfit(directions, np.where(turned, theirs, mine)[:, 3:])
        assert (np.abs(left).max() < 0.005) == (axis == 2)


def test_doubtful_claims_are_judged(recordings: Recordings) -> None:
    truths = {(each.recording, each.what.en): each.truth for each in doubtful(recordings)}
    bench = "vn200_57630_six_position"
    assert truths[bench, "a line at 14.158 Hz, there all the time"] == "true"
    assert truths["adi_mems_two_position", "a line at 36.702 Hz, there all the time"] == "false"
    assert truths[bench, "biases of the accelerometers wander"] == "false"
    assert truths["ferraris_session", "biases of the gyros wander"] == "cannot tell"
    assert truths[SHAFT, "gyro z jumps at 33.1 s"] == "false"


def finding(effect: str, channel: str, *parameters: tuple[str, float, float]) -> Answer:
    response = [{"name": n, "value": v, "u": u, "unit": ""} for n, v, u in parameters]
    return {"effect": effect, "channels": [channel], "parameters": response, "follows": None}


@pytest.mark.parametrize(
    ("key", "response", "outcome"),
    [
        ("earth", finding("earth_rotation", "gyro_x", ("vertical_rate", 11.8, 0.3)), "right"),
        (
            "earth",
            finding("earth_rotation", "gyro_x", ("vertical_rate", 14.0, 0.3)),
            "right name, value off",
        ),
        ("no_earth", finding("earth_rotation", "gyro_x", ("vertical_rate", 12.0, 1.0)), "wrong"),
        ("gyro_delay", finding("time_offset", "gyro_y", ("seconds", 0.0119, 1e-4)), "right"),
        (
            "gyro_delay",
            finding("bandwidth", "gyro_y", ("time_constant", 0.0072, 1e-4)),
            "right name, value off",
        ),
        ("low_pass", finding("bandwidth", "gyro_y", ("time_constant", 0.0043, 1e-4)), "right"),
        (
            "low_pass",
            finding("bandwidth", "gyro_y", ("time_constant", -0.01, 1e-4)),
            "right name, value off",
        ),
        ("mains", finding("mains_pickup", "accel_x", ("frequency", 60.0, 1e-4)), "right"),
        ("exchanged", finding("bias_step", "accel_z", ("time", 3.0, 0.1)), "wrong"),
        ("exchanged", finding("unnamed", "accel_z"), "right"),
        ("rounding", finding("coarse_quantisation", "accel_y"), "right"),
        ("ripple", finding("rate_ripple", "gyro_x"), "right"),
        ("ripple", finding("unnamed", "gyro_x", ("frequency", 4.0, 1e-3)), "right"),
        ("strongest_line", finding("unnamed", "gyro_z", ("frequency", 29.92, 1e-3)), "right"),
    ],
)
def test_an_answer_is_held_to_the_facts(
    facts: dict[str, Fact], key: str, response: Answer, outcome: str
) -> None:
    assert facts[key].declared({"findings": [response]}).outcome == outcome


def test_failure_is_said_and_an_empty_answer_is_silence(facts: dict[str, Fact]) -> None:
    for key, fact in facts.items():
        declared = fact.declared({"failed": "ValueError: broken\nin two lines"})
        assert declared.outcome == "explain failed"
        assert declared.words == "ValueError: broken"
        nothing = fact.declared({"findings": []}).outcome
        assert nothing == ("right" if key == "no_earth" else "silent")
