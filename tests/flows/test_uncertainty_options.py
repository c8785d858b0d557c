"""Ordering an evaluation of uncertainty, a laboratory's own limits, budgets, the joint method."""

import json
import re
import shutil
from pathlib import Path

import pypdfium2
import pytest

# Ordering an evaluation of uncertainty, a laboratory's own limits, and the budgets in print.

LABORATORY = """
party = {name = "L", name_zh = "实", address = "a", address_zh = "址"}
[limits.rate]
half_width = 2e-4
distribution = "normal"
source = "certificate 7"
"""


@pytest.fixture
def laboratory(tmp_path) -> Path:
    path = tmp_path / "laboratory.toml"
    path.write_text(LABORATORY, encoding="utf-8")
    return path


def words_of(pdf: str) -> str:
    pages = pypdfium2.PdfDocument(pdf)
    return re.sub(r"\s+", " ", " ".join(page.get_textpage().get_text_range() for page in pages))


def test_calibrate_gives_budgets_by_the_law_of_propagation(mimucal, plant_clean):
    done = mimucal("calibrate", plant_clean, "--json").json
    assert done["settings"]["uncertainty"] == "GUM"
    assert done["settings"]["limits"] == "JJF 2003-2022, Table 1"
    item = done["items"]["gyro_scale_factor"]
    budget = item["budgets"]["x"]
    assert (budget["u_c"], budget["U"]) == (item["u"]["x"], item["U"]["x"])
    assert {line["kind"] for line in budget["inputs"]} == {"A", "B"}


def test_calibrate_by_monte_carlo_repeats_digit_for_digit_and_states_its_intervals(
    mimucal, ahrs_clean
):
    ordered = ("calibrate", ahrs_clean, "--uncertainty", "montecarlo", "--json")
    done = mimucal(*ordered).json
    assert done == mimucal(*ordered).json
    assert done["settings"]["uncertainty"] == "Monte Carlo"
    assert done["settings"]["limits"] == "JJF 1536-2015, Table 1"
    for item in done["items"].values():
        for element, budget in item["budgets"].items():
            low, high = budget["coverage_interval"]
            assert low < item["value"][element] < high
    by_draws = ("--budget", "--uncertainty", "montecarlo", "--json")
    drafted = mimucal("certify", done["run"], *by_draws).json
    assert drafted["evidence"] is None
    printed = words_of(drafted["pdf"])
    assert "propagation of distributions by Monte Carlo" in printed
    assert "drawn from their distributions" in printed


def test_the_terminal_shows_the_coverage_factor_of_each_item(mimucal, shared, tmp_path):
    """Of a table whose encoders were not recorded, and that holds its rates as it states."""
    recorded = shared / "real/vn200_imu0_rate_table"
    manifest = json.loads((recorded / "manifest.json").read_text())
    bound = {"half_width": 1e-5, "distribution": "rectangular"}
    stated = json.dumps(manifest | {"table_time": {"commanded_rate": bound}})
    (tmp_path / "manifest.json").write_text(stated)
    shutil.copyfile(recorded / "imu.parquet", tmp_path / "imu.parquet")
    printed = mimucal("calibrate", tmp_path).out
    assert re.search(r"Gyro scale factor[^\n]*│ +4\.53 │", printed)


@pytest.mark.rehearsal
def test_certify_prints_the_budgets_and_uses_the_laboratory_it_is_given(
    mimucal, shared, laboratory
):
    certify = ("certify", shared / "real/ferraris_session", "--invalid-run", "--json")
    done = mimucal(*certify, "--budget", "--laboratory", laboratory).json
    words = words_of(done["pdf"])
    assert "Uncertainty budgets" in words
    assert "laboratory limit, table rate" in words
    assert "0.0002 (certificate 7)" in words
    assert "Uncertainty budgets" not in words_of(mimucal(*certify).json["pdf"])
    assert mimucal("verify", "--json").json["faults"] == []


def test_the_home_s_laboratory_tells_its_limits_to_calibrate(
    mimucal, plant_clean, home, laboratory
):
    home.mkdir(parents=True)
    (home / "laboratory.toml").write_bytes(laboratory.read_bytes())
    done = mimucal("calibrate", plant_clean, "--json").json
    assert done["settings"]["limit of rate"] == "0.0002 (certificate 7)"
    assert done["items"]["gyro_scale_factor"]["u"]["x"] == pytest.approx(1e-4, rel=0.01)


# The joint method as it is ordered: by --method, from any kind of recording.


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("real/xsens_multiposition", marks=pytest.mark.rehearsal),
        "real/ln100_two_position",
    ],
)
def test_a_joint_calibration_and_its_certificate_are_ordered_by_method(mimucal, shared, name):
    found = mimucal("calibrate", shared / name, "--method", "joint", "--json")
    assert found.code == 0
    assert found.json["method"] == "joint"
    assert len(found.json["items"]) == 9
    certificate = mimucal("certify", shared / name, "--method", "joint", "--budget", "--json")
    assert certificate.code == 0
    assert certificate.json["verdict"] == "inconclusive"
    assert Path(certificate.json["pdf"]).read_bytes().startswith(b"%PDF")


def test_accumulated_angles_are_sent_to_their_own_method(mimucal, ahrs_clean):
    refused = mimucal("calibrate", ahrs_clean, "--method", "joint")
    assert refused.code == 2
    assert "--method jjf1536" in refused.err
    assert "Traceback" not in refused.err
