"""The stated uncertainty is the scatter; the noise of the rates comes back from the angles."""

import json

import numpy as np
import pytest

from schemas.calibration import Calibration, Item
from schemas.recording import Recording
from tasks.calibrate.calibrate import calibrate
from tasks.specifications.jjf1536 import JJF1536
from tasks.specifications.jjf1536.evidence import fit_angle_noise, pooled_allan
from tests.tasks.items_only import items_only

# The stated uncertainty is the scatter: on the simulated AHRS and on noise of every kind.

AXES = "xyz"
K, B = (1.001, 0.999, 1.0), (0.002, -0.001, 0.003)
L = np.array([[0, 1e-3, -2e-3], [5e-4, 0, 1e-3], [-1e-3, 2e-3, 0]])
RATE_NOISE = np.radians(0.2) / 60  # rad/√s: 0.2 °/√h


def result(recording: Recording) -> Calibration:
    return items_only(JJF1536, recording)


def type_a(item: Item, element: str) -> float:
    line = item.budgets[element].inputs[0]
    assert line.kind == "A"
    return line.u


def deviations(calibration: Calibration, K, L, B_deg_s) -> dict[str, float]:
    """(value − truth)/u of every value, u of type A: the table of these runs is perfect."""
    truth = {"ahrs_scale_factor": np.diag(K), "ahrs_zero_offset": np.diag(B_deg_s),
             "ahrs_misalignment": np.degrees(L)}  # fmt: skip
    return {
        f"{name}.{element}": (value - truth[name][AXES.index(element[0]), AXES.index(element[-1])])
        / type_a(item, element)
        for name, item in calibration.items.items()
        for element, value in item.value.items()
    }


def rms(values) -> float:
    return float(np.sqrt(np.mean(np.square(list(values)))))


def test_the_simulated_ahrs_is_within_three_of_its_own_uncertainties(plant, shared):
    truth = json.loads((shared / "plant" / "ahrs_clean" / "truth.json").read_text())
    calibration = result(plant("ahrs_clean"))
    off = deviations(calibration, truth["K"], truth["L"], truth["B_deg_s"])
    assert len(off) == 12
    assert max(map(abs, off.values())) < 3
    assert 0.6 < rms(off.values()) < 1.4
    assert calibration.unavailable == {}
    assert {r.code for r in calibration.remarks} == {
        "environment_not_recorded", "supply_not_recorded", "unit_temperature_not_recorded",
    }  # fmt: skip


def test_the_simulated_ahrs_gives_the_same_by_its_rates(plant, as_gyro):
    recording = plant("ahrs_clean")
    table = recording.table
    by_angle = result(recording)
    by_rate = result(Recording(**{**vars(as_gyro(recording)), "table": table}))
    for name, item in by_angle.items.items():
        for element, value in item.value.items():
            assert by_rate.items[name].value[element] == pytest.approx(
                value, abs=0.2 * type_a(item, element)
            )
            assert type_a(by_rate.items[name], element) == pytest.approx(
                type_a(item, element), rel=0.4
            )


@pytest.mark.parametrize(
    "noise",
    [
        {"rate_noise": RATE_NOISE, "angle_noise": 0.0},
        {"rate_noise": RATE_NOISE, "angle_noise": 3e-4},
        {"rate_noise": RATE_NOISE, "angle_noise": 0.0, "step": np.radians(0.01)},
    ],
    ids=["random walk", "random walk and angle noise", "random walk and rounding to 0.01°"],
)
def test_values_scatter_as_their_uncertainty_says(ahrs_run, noise):
    runs = (ahrs_run(K=K, L=L, B=B, noise={**noise, "seed": seed}) for seed in range(8))
    off = [deviations(result(run), K, L, B) for run in runs]
    for item in ("scale", "zero", "misalignment"):
        values = [z for each in off for name, z in each.items() if item in name]
        assert 0.5 < rms(values) < 1.4


def test_an_angle_of_coarse_resolution_is_no_stuck_channel(ahrs_run):
    step = np.radians(0.01)
    run = ahrs_run(noise={"rate_noise": RATE_NOISE / 20, "angle_noise": 0.0, "step": step}, B=B)
    codes = {r.code for r in result(run).remarks}
    assert not codes & {"stuck", "samples_off"}
    assert "short_position" in codes


def test_both_noises_are_told_apart():
    random, interval, count = np.random.default_rng(7), 0.1, 6000
    walk, angle = np.array([1e-4, 5e-5, 0.0]), np.array([0.0, 1e-4, 1e-4])
    rests = []
    for _ in range(6):
        steps = np.sqrt(interval) * walk[:, None] * random.normal(size=(3, count))
        steps += np.diff(angle[:, None] * random.normal(size=(3, count + 1)), axis=1)
        rests.append(steps)
    found = fit_angle_noise(rests, interval, np.zeros(3))
    assert found.walk[:2] == pytest.approx(walk[:2] ** 2, rel=0.15)
    assert found.walk[2] < 0.02 * walk[0] ** 2
    assert found.angle[1:] == pytest.approx(angle[1:] ** 2, rel=0.05)
    assert found.angle[0] < 0.02 * walk[0] ** 2 * interval


def test_noise_of_the_angle_is_never_less_than_its_rounding():
    nothing = [np.zeros((3, 100))]
    step = np.array([1e-4, 2e-4, 0.0])
    found = fit_angle_noise(nothing, 0.1, step)
    assert found.angle == pytest.approx(step**2 / 12)
    assert not found.walk.any()
    assert fit_angle_noise([], 0.1, step).angle == pytest.approx(step**2 / 12)


def test_allan_variances_are_those_of_block_means():
    gain = np.random.default_rng(3).normal(size=(3, 8))
    variance, count = pooled_allan([gain], 0.5)
    blocks = gain.reshape(3, 4, 2).mean(axis=2) / 0.5
    assert variance[1] == pytest.approx(0.5 * (np.diff(blocks) ** 2).mean(axis=1))
    assert list(count) == [7, 3, 1]


# What stands beside the items of an AHRS: the noise and the line of its axes.

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
