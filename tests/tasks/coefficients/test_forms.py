"""Each form of a correction, read back as the software that it is for reads it."""

import csv
import io
import shutil
import subprocess

import numpy as np
import pytest
import yaml
from yaml.events import AliasEvent

from schemas.base import Unusable
from schemas.calibration import Coefficient, Correction
from schemas.recording import Recording
from tasks.calibrate.calibrate import calibrate, evaluation_for
from tasks.coefficients.correct import coefficients, correct
from tasks.coefficients.exports import as_c, as_csv, as_kalibr, as_ros, as_yaml, document
from tasks.specifications.jjf2003 import JJF2003
from tests.tasks.items_only import items_only

RNG = np.random.default_rng(9)
COMPILERS = {"gcc": ("-std=c99", "reading.c"), "g++": ("-std=c++11", "reading.cpp")}
PROGRAM = """
#include <stdio.h>
#include "correction.h"
int main(void)
{
    double gyro[3], accel[3], rate[3], force[3];
    int i;
    mimu_correct(MIMU_EXAMPLE_GYRO, MIMU_EXAMPLE_ACCEL, rate, force);
    for (i = 0; i < 3; i++)
        printf("%.17g %.17g\\n", rate[i] - MIMU_EXAMPLE_RATE[i], force[i] - MIMU_EXAMPLE_FORCE[i]);
    while (scanf("%lf %lf %lf %lf %lf %lf", &gyro[0], &gyro[1], &gyro[2],
                 &accel[0], &accel[1], &accel[2]) == 6) {
        mimu_correct(gyro, accel, rate, force);
        printf("%.17g %.17g %.17g %.17g %.17g %.17g\\n", rate[0], rate[1], rate[2],
               force[0], force[1], force[2]);
    }
    return 0;
}
"""


@pytest.fixture(scope="module")
def recording(plant) -> Recording:
    return plant("plant_earth_rotation")


@pytest.fixture(scope="module")
def calibration(recording):
    return calibrate(JJF2003, recording, run="r", code_version="v")


@pytest.fixture(scope="module")
def correction(calibration, recording) -> Correction:
    return document(calibration, recording.manifest.unit)


def matrix(correction: Correction, name: str) -> np.ndarray:
    return np.array(correction.coefficients[name].value)


@pytest.mark.parametrize("compiler", COMPILERS)
def test_the_compiled_header_gives_the_same_numbers(calibration, correction, tmp_path, compiler):
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    standard, name = COMPILERS[compiler]
    (tmp_path / "correction.h").write_text(as_c(correction), encoding="utf-8")
    (tmp_path / name).write_text(PROGRAM, encoding="utf-8")
    subprocess.run(
        [compiler, standard, "-Wall", "-Wextra", "-pedantic", "-Werror", "-Wno-unused-variable",
         "-Wno-unused-const-variable", name, "-o", "reading"],
        cwd=tmp_path, check=True,
    )  # fmt: skip
    gyro, accel = RNG.uniform(-5, 5, (20, 3)), RNG.uniform(-50, 50, (20, 3))
    lines = "".join(" ".join(map(repr, row)) + "\n" for row in np.hstack([gyro, accel]).tolist())
    done = subprocess.run(
        [tmp_path / "reading"], input=lines, capture_output=True, text=True, check=True
    )
    printed = [[float(number) for number in line.split()] for line in done.stdout.splitlines()]
    np.testing.assert_allclose(printed[:3], 0.0, atol=1e-14)
    expected = np.hstack(correct(coefficients(calibration)[0], gyro, accel))
    np.testing.assert_allclose(printed[3:], expected, rtol=1e-13, atol=1e-13)


def test_names_of_a_unit_cannot_leave_the_comment(correction):
    unit = correction.unit.model_copy(update={"model": "M*/ int x;\n/* 7"})
    text = as_c(correction.model_copy(update={"unit": unit}))
    head = text[: text.index("#ifndef")]
    assert head.count("*/") == 1
    assert head.rstrip().endswith("*/")
    for form in (as_ros, as_yaml):
        assert yaml.safe_load(form(correction.model_copy(update={"unit": unit})))


def test_formulas_of_the_document_give_its_example(correction):
    """Whoever follows the printed steps, with the printed matrices, arrives at the example."""
    names = {name: matrix(correction, name) for name in correction.coefficients}
    names |= {n: np.array(value) for n, value in correction.example if n in ("gyro", "accel")}
    for formula in correction.correction:
        name, right = formula.replace("^", "**").split(" = ")
        names[name] = eval(right.replace("*(", "@(").replace("G*", "G@").replace("P*", "P@"), names)
    np.testing.assert_allclose(names["rate"], correction.example.rate, rtol=1e-13)
    np.testing.assert_allclose(names["force"], correction.example.force, rtol=1e-13)


def by_ros(correction: Correction) -> dict[str, list[float]]:
    """The parameters of every node.

    ROS takes lists of one type, none in another, and no aliases (ros2/rcl, rcl_yaml_param_parser,
    src/parse.c). What YAML 1.1 reads as a float its strtod reads as one.
    """
    text = as_ros(correction)
    assert not [event for event in yaml.parse(text) if isinstance(event, AliasEvent)]
    return yaml.safe_load(text)["/**"]["ros__parameters"]["imu_correction"]


def test_ros_file_gives_every_node_each_coefficient_by_ros_own_rules(correction):
    parameters = by_ros(correction)
    assert parameters.pop("formulas") == list(correction.correction)
    assert parameters.keys() == correction.coefficients.keys()
    for name, values in parameters.items():
        assert {type(value) for value in values} == {float}, name
        wanted = matrix(correction, name)
        np.testing.assert_array_equal(np.reshape(values, wanted.shape), wanted)
    assert "Plant M-tactical" in as_ros(correction)


def test_ros_file_of_an_ideal_unit_is_still_of_floats(correction):
    """Zeros, ones and the smallest numbers are written so that no list mixes types."""
    plain = Coefficient(unit="1", value=((1.0, 0.0, -0.0), (1e-300, 1.0, 1e22), (0.0, 5e-7, 1.0)))
    ideal = correction.model_copy(update={"coefficients": {"K_g": plain}})
    values = by_ros(ideal)["K_g"]
    assert values == [number for row in plain.value for number in row]
    assert {type(value) for value in values} == {float}


def test_csv_has_a_row_for_each_element(correction):
    rows = list(csv.DictReader(io.StringIO(as_csv(correction))))
    found = {(r["coefficient"], r["reads"], r["input"]): r for r in rows}
    assert len(found) == len(rows) == 6 * 9 + 2 * 3
    element = found["K_g", "x", "y"]
    assert float(element["value"]) == matrix(correction, "K_g")[0, 1]
    assert float(element["U"]) == correction.coefficients["K_g"].U[0][1]
    assert (found["B_g", "z", ""]["unit"], found["C_a", "x", "x"]["U"]) == ("rad/s", "")


def test_every_form_says_how_its_uncertainties_were_evaluated(recording, correction):
    by_example = evaluation_for(recording, "as the specification's example")
    made = document(items_only(JJF2003, recording, by_example), recording.manifest.unit)
    for each, kind in ((correction, "GUM"), (made, "as the specification's example")):
        assert each.uncertainty == kind
        stated = next(csv.DictReader(io.StringIO(as_csv(each))))
        assert stated["evaluation"] == kind
        assert f"U: {kind}" in as_c(each)
    assert made.covariance is None
    assert correction.covariance is not None
    assert "gyro_scale_factor.x" in correction.covariance.elements


KALIBR_STATISTICS = (
    "accelerometer_noise_density", "accelerometer_random_walk",
    "gyroscope_noise_density", "gyroscope_random_walk",
)  # fmt: skip


def test_kalibr_reads_the_file_and_its_model_gives_the_units_readings(
    calibration, correction, recording
):
    """As ethz-asl/kalibr takes a file (kalibr_common/ConfigReader.py) and what its
    scale-misalignment model makes of it (kalibr_imu_camera_calibration/IccSensors.py).
    """
    stated = yaml.safe_load(as_kalibr(correction, calibration, recording))
    assert (stated["model"], type(stated["rostopic"])) == ("scale-misalignment", str)
    assert stated["update_rate"] == pytest.approx(100.0)
    for name in KALIBR_STATISTICS:
        assert isinstance(stated[name], float)  # text, as YAML 1.1 reads 1e-5, is none
        assert stated[name] > 0.0
    gyros, accels = stated["gyroscopes"], stated["accelerometers"]
    to_body = np.array(stated["T_i_b"])
    m_gyro, m_accel = np.array(gyros["M"]), np.array(accels["M"])
    assert not np.triu([m_gyro, m_accel], 1).any()  # no design variables of kalibr's
    assert to_body[3].tolist() == [0.0, 0.0, 0.0, 1.0]
    turns = np.array(gyros["C_gyro_i"]), to_body[:3, :3]
    for turn in turns:  # kalibr makes a quaternion of it
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(turn) > 0.0
    rate, force = RNG.uniform(-5, 5, 3), RNG.uniform(-50, 50, 3)
    whole = turns[0] @ turns[1]
    gyro = m_gyro @ whole @ rate + np.array(gyros["A"]) @ whole @ force
    ours = matrix(correction, "K_g") @ rate + matrix(correction, "G") @ force
    np.testing.assert_allclose(gyro, ours, rtol=1e-12)
    accel = m_accel @ turns[1] @ force
    np.testing.assert_allclose(accel, matrix(correction, "K_a") @ force, rtol=1e-12)


def test_kalibr_is_refused_where_no_noise_shows(calibration, correction, recording):
    quiet = calibration.model_copy(update={"information": {}})
    with pytest.raises(Unusable, match="no white noise of the gyro triad"):
        as_kalibr(correction, quiet, recording)
