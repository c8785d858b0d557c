"""Each form of a correction, read back as the software that it is for reads it."""

import csv
import io
import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import yaml

from schemas.base import Unusable
from schemas.correction import Correction
from schemas.recording import Recording
from tasks.calibrate.calibrate import calibrate
from tasks.coefficients.c_header import as_c
from tasks.coefficients.correct import coefficients, correct
from tasks.coefficients.document import document
from tasks.coefficients.kalibr import as_kalibr
from tasks.coefficients.tables import as_csv, as_json, as_ros, as_yaml
from tasks.specifications.jjf2003 import JJF2003

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
def calibration(recording: Recording):
    return calibrate(JJF2003, recording, run="r", code_version="v")


@pytest.fixture(scope="module")
def correction(calibration, recording) -> Correction:
    return document(calibration, recording.manifest.unit)


def matrix(correction: Correction, name: str) -> np.ndarray:
    return np.array(correction.coefficients[name].value)


@pytest.mark.parametrize("compiler", COMPILERS)
def test_the_compiled_header_gives_the_same_numbers(
    calibration, correction, tmp_path: Path, compiler: str
) -> None:
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


def test_names_of_a_unit_cannot_leave_the_comment(correction) -> None:
    unit = correction.unit.model_copy(update={"model": "M*/ int x;\n/* 7"})
    text = as_c(correction.model_copy(update={"unit": unit}))
    head = text[: text.index("#ifndef")]
    assert head.count("*/") == 1
    assert head.rstrip().endswith("*/")
    for form in (as_ros, as_yaml):
        assert yaml.safe_load(form(correction.model_copy(update={"unit": unit})))


def test_document_survives_json_and_yaml(correction) -> None:
    assert Correction.model_validate_json(as_json(correction)) == correction
    assert Correction.model_validate(yaml.safe_load(as_yaml(correction))) == correction


def test_formulas_of_the_document_give_its_example(correction) -> None:
    """Whoever follows the printed steps, with the printed matrices, arrives at the example."""
    names = {name: matrix(correction, name) for name in correction.coefficients}
    names |= {n: np.array(value) for n, value in correction.example if n in ("gyro", "accel")}
    for formula in correction.correction:
        name, right = formula.replace("^", "**").split(" = ")
        names[name] = eval(right.replace("*(", "@(").replace("G*", "G@").replace("P*", "P@"), names)
    np.testing.assert_allclose(names["rate"], correction.example.rate, rtol=1e-13)
    np.testing.assert_allclose(names["force"], correction.example.force, rtol=1e-13)


def test_ros_parameters_are_lists_of_one_type_under_the_wildcard(correction) -> None:
    text = as_ros(correction)
    parameters = yaml.safe_load(text)["/**"]["ros__parameters"]["imu_correction"]
    for name, values in parameters.items():
        kind = str if name == "formulas" else float
        assert {type(value) for value in values} == {kind}, name
    np.testing.assert_array_equal(np.reshape(parameters["C_g"], (3, 3)), matrix(correction, "C_g"))
    assert "Plant M-tactical" in text


def test_csv_has_a_row_for_each_element(correction) -> None:
    rows = list(csv.DictReader(io.StringIO(as_csv(correction))))
    found = {(r["coefficient"], r["reads"], r["input"]): r for r in rows}
    assert len(found) == len(rows) == 6 * 9 + 2 * 3
    element = found["K_g", "x", "y"]
    assert float(element["value"]) == matrix(correction, "K_g")[0, 1]
    assert float(element["U"]) == correction.coefficients["K_g"].U[0][1]
    assert (found["B_g", "z", ""]["unit"], found["C_a", "x", "x"]["U"]) == ("rad/s", "")


def test_kalibr_gets_its_fields_and_the_units_intrinsics(
    calibration, correction, recording
) -> None:
    """What kalibr's reader asks for, and its own measurement model gives the unit's readings."""
    document = yaml.safe_load(as_kalibr(correction, calibration, recording))
    assert isinstance(document["rostopic"], str)
    for name in ("update_rate", "accelerometer_noise_density", "accelerometer_random_walk",
                 "gyroscope_noise_density", "gyroscope_random_walk"):  # fmt: skip
        assert document[name] > 0.0, name
    assert document["update_rate"] == pytest.approx(100.0)
    rate, force = RNG.uniform(-5, 5, 3), RNG.uniform(-50, 50, 3)
    gyros, accels = document["gyroscopes"], document["accelerometers"]
    c_i = np.array(document["T_i_b"])[:3, :3]
    c_gyro = np.array(gyros["C_gyro_i"]) @ c_i
    for lower, rotation in ((gyros["M"], c_gyro), (accels["M"], c_i)):
        assert not np.triu(lower, 1).any()
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(rotation) == pytest.approx(1.0)
    by_kalibr = gyros["M"] @ (c_gyro @ rate) + gyros["A"] @ (c_gyro @ force)
    ours = matrix(correction, "K_g") @ rate + matrix(correction, "G") @ force
    np.testing.assert_allclose(by_kalibr, ours, rtol=1e-12)
    np.testing.assert_allclose(
        accels["M"] @ (c_i @ force), matrix(correction, "K_a") @ force, rtol=1e-12
    )


def test_kalibrs_noise_is_that_of_the_rests(calibration, correction, recording) -> None:
    """White noise at 100 Hz: the density is the scatter of a row over √(rate)."""
    document = yaml.safe_load(as_kalibr(correction, calibration, recording))
    rest = next(s for s in calibration.segments if s.kind == "static")
    rows = recording.imu.rows(rest.t_start, rest.t_end)
    scatter = recording.imu.channels(("accel_x", "accel_y", "accel_z"), rows).std(axis=1)
    density = document["accelerometer_noise_density"]
    assert density == pytest.approx(scatter.max() / 10.0, rel=0.2)


def test_kalibr_is_refused_where_no_noise_shows(calibration, correction, recording) -> None:
    quiet = calibration.model_copy(update={"information": {}})
    with pytest.raises(Unusable, match="no white noise of the gyro triad"):
        as_kalibr(correction, quiet, recording)


def test_published_names_of_the_document_are_plain_ascii(correction) -> None:
    """Firmware tools read formulas and units as ASCII."""
    plain = correction.model_dump(mode="json", exclude={"unit", "recording_id"})
    assert json.dumps(plain, ensure_ascii=False).isascii()
