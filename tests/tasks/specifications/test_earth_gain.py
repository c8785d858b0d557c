"""Whether the rests of a recording show Earth's rotation."""

import numpy as np
import pytest

from schemas.recording import Recording, Stream
from tasks.calibrate.calibrate import calibrate
from tasks.calibrate.information.entry import EARTH_ROTATION, WITHOUT_EARTH
from tasks.motion.table import EARTH_RATE
from tasks.specifications.evidence import EarthRotationGain, earth_rotation_message, gather
from tasks.specifications.jjf2003 import JJF2003
from tasks.words import texts
from tests.manifests import at_station


def seen_in(recording: Recording) -> EarthRotationGain:
    found = gather(recording).earth
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("name", "gain", "state"),
    [
        ("plant_clean", 0.0, "not_shown"),
        ("plant_lever_arm", 0.0, "not_shown"),
        ("plant_earth_rotation", 1.0, "present"),
    ],
)
def test_headings_apart_tell_whether_a_simulated_earth_turned(plant, name, gain, state):
    found = seen_in(plant(name, 4))
    assert found.level
    assert abs(found.gain - gain) < 2.0 * found.u
    assert found.u < 0.2
    assert found.state == state


def test_a_g_sensitivity_is_not_taken_for_earth_rotation(plant):
    """It turns with gravity, which no heading changes."""
    recording = plant("plant_clean", 4)
    columns = {name: values.copy() for name, values in recording.imu.columns.items()}
    up = columns["accel_x"] / 9.78
    columns["gyro_x"] += 1e-3 * up
    columns["gyro_y"] += 1e-3 * up
    sensitive = Recording(recording.manifest, Stream(recording.imu.t, columns), recording.table)
    before, after = seen_in(recording), seen_in(sensitive)
    assert abs(after.gain - before.gain) < 2.0 * before.u


def test_up_minus_down_alone_refutes_nothing_and_finds_a_quiet_gyro_on_the_earth(real):
    quiet = seen_in(real("ln100_two_position"))
    assert (quiet.level, quiet.state) == (False, "present")
    assert quiet.gain == pytest.approx(1.0, abs=0.02)
    assert (
        "provided the unit's own g-sensitivity is small"
        in texts(earth_rotation_message(quiet))["en"]
    )
    noisy = seen_in(real("adi_mems_two_position"))
    assert noisy.state == "not_visible"
    assert not EarthRotationGain(0.0, 0.01, level=False).refuted


@pytest.mark.parametrize(
    ("gain", "u", "state"),
    [(1.0, 0.1, "present"), (0.5, 0.3, "not_visible"), (0.0, 0.1, "not_shown"), (-1.0, 0.1, "odd")],
)
def test_states_follow_from_three_standard_uncertainties(gain, u, state):
    assert EarthRotationGain(gain, u, level=True).state == state
    assert texts(earth_rotation_message(EarthRotationGain(gain, u, level=True)))["zh"]


def test_without_a_latitude_there_is_no_gain(ideal_run):
    assert gather(at_station(ideal_run(), latitude_deg=None)).earth is None


@pytest.mark.parametrize("name", ["plant_clean", "plant_earth_rotation"])
def test_only_where_it_is_seen_the_value_is_said_to_contain_it(plant, name):
    found = calibrate(JJF2003, plant(name, 4), run="r", code_version="v")
    texts = [remark.en for remark in found.remarks] + [found.information[WITHOUT_EARTH].en]
    includes = [text for text in texts if "includes" in text and "Earth" in text]
    assert bool(includes) == (name == "plant_earth_rotation")
    twice = [text for text in texts if "removed twice" in text]
    assert len(twice) == (0 if includes else 2)
    gain = found.information[EARTH_ROTATION]
    assert gain.unit == "1"
    assert gain.U == {"λ": None}  # what it would be is of type A only, and stands in the text
    assert "type A only" in gain.en
    item = found.items["gyro_g_sensitivity"]
    vertical = np.degrees(EARTH_RATE * np.sin(np.radians(39.9)))
    assert item.value["xx"] - item.value_without_earth_rotation["xx"] == pytest.approx(
        vertical, rel=0.02
    )
