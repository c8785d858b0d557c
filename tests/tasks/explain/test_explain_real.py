"""`explain` on other people's hardware, where something is known of what was left out."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.recording import Recording
from storage.formats.folder import read_folder
from tasks.explain.explain import explain
from tasks.explain.explanation import Explanation, Finding
from tests.shared import shared_path

EARTH = 15.04107  # deg/h
LONGEST = 20.0  # s: they tell as much of a shaft as the five minutes
LATITUDE = 51.0784  # deg, of the ring-laser unit's laboratory
DELAYS = ("time_offset", "bandwidth")


@cache
def explained(name: str) -> Explanation:
    return explain(beginning(read_folder(shared_path(f"data/real/{name}"))))


def beginning(whole: Recording) -> Recording:
    """The first seconds of a recording whose motion its table tells; any other as it is."""
    if whole.table is None:
        return whole
    imu, table = (stream.at(stream.rows(0.0, LONGEST)) for stream in (whole.imu, whole.table))
    return replace(whole, imu=imu, table=table)


def named(name: str, *effects: str) -> list[Finding]:
    return [each for each in explained(name).findings if each.effect in effects]


def test_a_ring_laser_unit_in_two_positions_sees_earth_turn():
    (earth,) = named("ln100_two_position", "earth_rotation")
    (vertical,) = earth.parameters
    assert (vertical.name, vertical.unit) == ("vertical_rate", "deg/h")
    true = EARTH * np.sin(np.radians(LATITUDE))
    assert abs(vertical.value - true) < 2.0 * vertical.u
    assert vertical.u < 1.0
    assert earth.channels == (0,)  # x stands upwards, then downwards
    # No residual shows it; that g-sensitivity has its very value is not by chance.
    assert earth.share < 0.01
    assert explained("ln100_two_position").p_value < 0.005


@pytest.mark.rehearsal
def test_a_wrong_mapping_is_no_share_of_the_mismatch_that_is_left_beside_it():
    answer = explained("vn200_57630_six_position")
    first, *others = answer.findings
    assert (first.effect, first.share) == ("axis_mapping", 0.0)
    shares = [one.share for one in (*others, *answer.small)]
    assert sum(shares) == pytest.approx(answer.explained_share, abs=0.02)


@pytest.mark.rehearsal
def test_a_mems_unit_in_two_positions_does_not_see_it():
    assert named("adi_mems_two_position", "earth_rotation") == []


@pytest.mark.rehearsal
def test_a_unit_with_a_low_pass_is_late_against_an_encoder():
    """Its maker says 4.8 ms; the encoder's and the bus's delays are not known."""
    late = named("encoder_mpu6050_pitch_slow", *DELAYS)
    assert late
    assert 1 in late[0].channels  # the shaft turns the unit about y
    seconds = sum(p.value for each in late for p in each.parameters if p.unit == "s")
    assert 0.002 < seconds < 0.015
    assert late[0].held_out_gain > 100.0


def test_a_recording_that_tells_no_motion_is_refused_in_one_sentence(
    real,
):
    with pytest.raises(Unusable) as refused:
        explain(real("xsens_multiposition"))
    text = str(refused.value)
    assert "xsens_multiposition does not show how the unit moved" in text
    assert "\n" not in text
    assert text.count(". ") == 0
