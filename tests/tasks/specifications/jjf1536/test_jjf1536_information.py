"""What stands beside the items of an AHRS: the noise and the line of its axes."""

import numpy as np
import pytest

from tasks.calibrate.calibrate import calibrate
from tasks.specifications.jjf1536 import JJF1536

WALK = 5e-5  # rad/√s


def test_the_white_noise_of_the_rates_is_recovered_from_the_angles(ahrs_run):
    recording = ahrs_run(hold=200.0, noise={"rate_noise": WALK, "angle_noise": 1e-5})
    found = calibrate(JJF1536, recording, run="r", code_version="v").information
    assert not [name for name in found if name.startswith(("gyro", "accel"))]
    walk = found["ahrs_angle_random_walk"]
    for axis in "xyz":
        truth = 60.0 * float(np.degrees(WALK))
        assert walk.value[axis] == pytest.approx(truth, abs=3 * walk.u[axis])


def test_non_linearity_stands_beside_the_scale_factor(ahrs_run):
    found = calibrate(JJF1536, ahrs_run(), run="r", code_version="v").information
    assert found["ahrs_scale_nonlinearity"].about == "ahrs_scale_factor"
    assert found["ahrs_scale_nonlinearity"].value["x"] == pytest.approx(0.0, abs=0.01)
    assert found["ahrs_scale_asymmetry"].value["x"] == pytest.approx(0.0, abs=0.01)
