"""`mimucal explain` on the command line: what it prints, writes and refuses.

The engine is replaced by one whose answer is known; the last tests run it as it is.
"""

import errno
import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest

from schemas.discrepancy import FoundParameter, HeldOut
from schemas.procedure import EnvironmentLimits, Position, Procedure
from schemas.recording import ACCEL, GYRO, Recording
from schemas.text import Statement
from storage import settings
from storage.catalogue import runs
from storage.formats.folder import read_folder
from storage.home import Home
from tasks.experiment import blocks, separation
from tasks.experiment.choose import Choice, Experiment, OpenQuestion
from tasks.explain.explanation import CHANNELS, Explanation, Finding
from tasks.stages import next_recording
from tasks.words import LANGUAGES, say

SMALL = "real/ferraris_session"
BLANK = {name: dict.fromkeys(LANGUAGES, "<svg/>") for name in ("where", "before_after", "shares")}
EARTH = 7.292115e-5  # rad/s
STEP = 0.01  # deg/s that the known answer adds to gyro x


def known_answer(recording: Recording, findings: int = 1) -> Explanation:
    """A constant on gyro x, as if a finding."""
    added = np.zeros((len(recording.imu.t), len(CHANNELS)))
    nominal = recording.imu.stack(CHANNELS)
    added[:, 0] = np.radians(STEP)
    found = Finding(
        effect="bias_step", family="memory", title=Statement(en="bias step", zh="零偏阶跃"),
        equation="ω′ = ω + b",
        source="test", channels=(0,), contribution=added, gain=100.0, delta_bic=90.0,
        held_out_gain=40.0,
        parameters=(FoundParameter(name="gyro_x", value=STEP, unit="deg/s", u=STEP / 20),),
    )  # fmt: skip
    return Explanation(
        recording=recording, nominal=nominal, found=nominal + findings * added,
        noise=np.full(len(CHANNELS), 1e-4), p_value=1e-9 if findings else 0.5,
        verdict="explained" if findings else "no_mismatch", findings=(found,) * findings,
        held_out=HeldOut(
            rms_ratio={"gyro_x": 0.7}, chi2_per_dof_before=2.0, chi2_per_dof_after=1.0
        ),
    )  # fmt: skip


@pytest.fixture
def engine(monkeypatch) -> Callable[[int], dict[str, Any]]:
    """Has the engine find so many things; gives what it was last asked with."""

    def finding(count: int) -> dict[str, Any]:
        asked: dict[str, Any] = {}

        def prepare(recording: Recording, reference: object, **more: Any) -> Recording:
            asked.update(more, recording=recording, reference=reference)
            return recording

        def explained(recording: Recording, **more: Any) -> Explanation:
            asked.update(more)
            return known_answer(recording, count)

        monkeypatch.setattr("tasks.stages.explain.prepare", prepare)
        monkeypatch.setattr("tasks.stages.explain.explained", explained)
        for room in ("tasks.explain.explain", "tasks.stages.explain"):
            monkeypatch.setattr(f"{room}.explain", explained)
        # Of the page that is kept; a report that is asked for has its own.
        monkeypatch.setattr("tasks.stages.explain.pictures_of", lambda *_: BLANK)
        monkeypatch.setattr("tasks.stages.explain.keep_statistics", lambda *_: None)
        return asked

    return finding


def test_json_is_the_document_of_the_contract(mimucal, shared, engine):
    engine(1)
    done = mimucal("explain", shared / SMALL, "--json")
    assert done.code == 0, done.err
    assert done.json["format"] == "mimu-discrepancy/1"
    assert (done.json["recording_id"], done.json["verdict"]) == ("ferraris_session", "explained")
    (finding,) = done.json["findings"]
    assert finding["effect"] == "bias_step"
    assert finding["channels"] == ["gyro_x"]
    assert finding["parameters"][0]["value"] == STEP
    assert sum(where["share"] for where in finding["where"]) == pytest.approx(1.0)
    moved = {(c["item"], c["element"]): c for c in finding["consequences"]}
    bias = moved["gyro_bias", "x"]
    assert bias["before"] - bias["after"] == pytest.approx(STEP, rel=1e-6)


def test_a_person_reads_the_verdict_the_finding_and_what_it_matters(mimucal, shared, engine):
    engine(1)
    done = mimucal("explain", shared / SMALL)
    assert done.code == 0, done.err
    assert "explained" in done.out
    assert "bias_step" in done.out
    assert "0.0100" in done.out
    assert "bias of the x gyro" in done.out.lower()


def test_without_out_nothing_is_written_and_with_it_the_whole_report(
    mimucal, shared, engine, tmp_path, monkeypatch
):
    engine(1)
    monkeypatch.chdir(tmp_path)
    before = {path.name for path in tmp_path.iterdir()}
    assert mimucal("explain", shared / SMALL).code == 0
    assert {path.name for path in tmp_path.iterdir()} - before == {"home"}
    done = mimucal("explain", shared / SMALL, "--out", tmp_path / "a" / "report", "--json")
    assert done.code == 0, done.err
    written = {path.name for path in (tmp_path / "a" / "report").iterdir()}
    assert {"report.html", "report.json", "prediction.parquet"} <= written
    assert set(done.json["figures"]) <= written
    table = pq.read_table(tmp_path / "a" / "report" / "prediction.parquet")
    imu = read_folder(shared / SMALL).imu
    assert table.column_names[0] == "t"
    assert {f"{c}_{kind}" for c in CHANNELS for kind in ("nominal", "found")} <= set(
        table.column_names
    )
    np.testing.assert_array_equal(table.column("t").to_numpy(), imu.t)


def test_a_result_and_a_simulation_reach_the_engine(mimucal, plant_clean, engine, tmp_path):
    asked = engine(0)
    calibration = mimucal("calibrate", plant_clean, "--json")
    (kept,) = mimucal("show", calibration.json["run"], "--json").json["results"]
    assert mimucal("simulate", plant_clean, "--out", tmp_path / "sim").code == 0
    by_result = mimucal("explain", plant_clean, "--calibration", kept["id"])
    assert by_result.code == 0, by_result.err
    simulated = read_folder(tmp_path / "sim").imu.stack(CHANNELS)
    np.testing.assert_allclose(asked["reference"].readings, simulated, atol=1e-12)
    assert "calibration" in say(asked["reference"].model, "en")
    assert mimucal("explain", plant_clean, "--simulated", tmp_path / "sim").code == 0
    np.testing.assert_array_equal(asked["reference"].readings, simulated)
    assert "simulation" in say(asked["reference"].model, "en")


@pytest.mark.rehearsal
def test_limits_in_the_home_say_whether_a_verdict_changes(mimucal, plant_clean, engine, home):
    engine(1)
    bias = mimucal("calibrate", plant_clean, "--json").json["items"]["gyro_bias"]["value"]["x"]
    middle = bias - STEP / 2
    (home / "tolerances").mkdir()
    (home / "tolerances" / "m.toml").write_text(
        'format = "mimu-tolerance/1"\nmanufacturer = "Plant"\nmodel = "M-industrial"\n'
        'document = "d"\n[[limits]]\nitem = "gyro_bias"\nunit = "deg/s"\nelements = ["x"]\n'
        f"lower = {middle - 1}\nupper = {middle}\n",
        encoding="utf-8",
    )
    done = mimucal("explain", plant_clean, "--json")
    changes = {c["item"]: c for c in done.json["findings"][0]["verdict_changes"]}
    assert (changes["gyro_bias"]["before"], changes["gyro_bias"]["after"]) == ("fail", "pass")
    assert "fail → pass" in mimucal("explain", plant_clean).out


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--calibration", "nowhere"), "no result"),
        (("--simulated", "nowhere"), "nowhere"),
        (("--out", "taken/below"), "--out"),
    ],
)
def test_what_cannot_be_used_is_one_sentence(
    mimucal, shared, engine, tmp_path, monkeypatch, arguments, says
):
    engine(1)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").write_text("a file", encoding="utf-8")
    done = mimucal("explain", shared / SMALL, *arguments)
    assert (done.code, done.out) == (2, "")
    assert done.err.strip().count("\n") == 0
    assert says in done.err


def test_terms_are_taken_off_and_the_result_supersedes_none_without_them(mimucal, shared, engine):
    asked = engine(1)
    plain = mimucal("calibrate", shared / SMALL, "--json").json
    done = mimucal("calibrate", plain["run"], "--terms", "bias_step", "--json")
    assert done.code == 0, done.err
    assert "only" not in asked  # what explain found is taken off as it found it
    (term,) = done.json["terms"]
    assert term["parameters"] == [
        {"name": "gyro_x", "value": STEP, "unit": "deg/s", "u": STEP / 20}
    ]
    before, after = (each["items"]["gyro_bias"] for each in (plain, done.json))
    assert before["value"]["x"] - after["value"]["x"] == pytest.approx(STEP, rel=1e-6)
    assert after["u"]["x"] == pytest.approx(np.hypot(before["u"]["x"], STEP / 20), rel=1e-4)
    assert after["u"]["y"] == pytest.approx(before["u"]["y"])
    again = mimucal("calibrate", plain["run"], "--json").json
    assert again["items"] == plain["items"]
    mimucal("calibrate", plain["run"], "--terms", "bias_step")
    kept = mimucal("show", plain["run"], "--json").json["results"]
    assert [len(result["calibration"]["terms"]) for result in kept] == [0, 1]
    assert [result["supersedes"] for result in kept] == [None, None]
    assert mimucal("verify", "--json").json["faults"] == []


@pytest.mark.rehearsal
def test_what_explain_did_not_find_is_fitted_alone(mimucal, shared, engine):
    asked = engine(1)
    assert mimucal("calibrate", shared / SMALL, "--terms", "lever_arm").code == 2
    assert asked["only"] == ("lever_arm",)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--terms", "lever_arm,moon"), "lever_arm, "),
        (("--terms", " , "), "lever_arm, "),
        (("--terms", "lever_arm"), "does not determine it"),
        (("--terms", "bias_step", "--method", "joint"), "joint"),
        (("--terms", "bias_step", "--uncertainty", "montecarlo"), "propagation"),
    ],
)
def test_what_cannot_be_adopted_is_one_sentence(mimucal, shared, engine, arguments, says):
    engine(1)
    done = mimucal("calibrate", shared / SMALL, *arguments)
    assert (done.code, done.out) == (2, "")
    assert done.err.strip().count("\n") == 0
    assert says in done.err


@pytest.fixture
def first_half(plant_on_earth, tmp_path) -> Path:
    """All positions, and one axis of three turned about."""
    folder, end = tmp_path / plant_on_earth.name, 807.0
    folder.mkdir()
    manifest = json.loads((plant_on_earth / "manifest.json").read_text(encoding="utf-8"))
    manifest["segments"] = [each for each in manifest["segments"] if each["t_end"] <= end]
    (folder / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    for file in plant_on_earth.glob("*.parquet"):
        rows = pq.read_table(file)
        pq.write_table(rows.filter(pc.less_equal(rows["t"], end)), folder / file.name)
    return folder


def test_engine_as_it_is_names_the_missing_physics_and_writes_the_report(
    mimucal, first_half, tmp_path, monkeypatch
):
    monkeypatch.setattr("tasks.stages.explain.pictures_of", lambda *_: BLANK)  # of the kept page
    done = mimucal("explain", first_half, "--out", tmp_path / "report", "--json")
    assert done.code == 0, done.err
    assert done.json["verdict"] == "explained"
    assert done.json["findings"][0]["effect"] == "earth_rotation"
    moved = {(c["item"], c["element"]): c for c in done.json["findings"][0]["consequences"]}
    latitude = np.radians(read_folder(first_half).manifest.station.latitude_deg)
    vertical = np.degrees(EARTH * np.sin(latitude))  # deg/s, that stands still with a vertical axis
    change = moved["gyro_g_sensitivity", "zz"]
    assert change["before"] - change["after"] == pytest.approx(vertical, rel=0.05)
    assert (tmp_path / "report" / "report.html").exists()


# `mimucal next`: the procedure that it writes is one that `acquire` takes; refusals are said.

PROCEDURE = Procedure(
    name="decide", title="t", title_zh="t", standard="other", warm_up_s=0.0, settle_s=0.1,
    environment=EnvironmentLimits(temperature_degc=(15, 25), humidity_percent=(20, 80)),
    move_rate_deg_s=60, acceleration_deg_s2=100,
    steps=(Position(name="rest", item="i", up="+z", angles_deg=(0, 0, 0), dwell_s=2.0),),
)  # fmt: skip


@pytest.fixture
def run(home, ideal_run) -> str:
    return runs.add(ideal_run(dwell=1.0), Home(home))[0].id


@pytest.fixture
def answered(monkeypatch) -> Callable[..., None]:
    """The engine with a known answer: the chi-squared that its procedure shows."""

    def answer(left: float, *names: str) -> None:
        fit = SimpleNamespace(blocks=None, noises=())
        names = names or ("time_offset", "bandwidth")
        question = OpenQuestion(names, {}, {}, fit)  # type: ignore[arg-type]
        monkeypatch.setattr(next_recording, "rivals_of", lambda *_: {})
        monkeypatch.setattr(next_recording, "open_question", lambda *_: question)
        monkeypatch.setattr(separation.UnitNoise, "of", lambda *_: None)
        able = SimpleNamespace(chamber=None)
        monkeypatch.setattr(blocks.Abilities, "of_recording", lambda *_: able)
        least = Choice(PROCEDURE, 1.5, left, 30.0, left)
        monkeypatch.setattr(Experiment, "shortest", lambda *_: least)
        typical = replace(least, expected=1.25 * left)
        monkeypatch.setattr(Experiment, "judged", lambda *_: typical)
        monkeypatch.setattr(Experiment, "left_by", lambda *_: 2.0)

    return answer


def test_the_recording_that_decides_is_a_procedure_that_acquire_takes(
    run, answered, mimucal, tmp_path
):
    answered(80.0)
    out = tmp_path / "next.json"
    done = mimucal("next", run, "--out", str(out), "--json")
    assert (done.code, done.json["format"]) == (0, "mimu-next/1")
    assert done.json["decides"] == ["time_offset", "bandwidth"]
    assert done.json["procedure"] == str(out)
    assert done.json["minutes"] == 1.5
    assert done.json["predicted"]["delta_chi2"] == 80.0
    assert done.json["repeat_of_base"]["delta_chi2"] == 2.0
    assert settings.read(out, Procedure) == PROCEDURE
    assert [step["name"] for step in done.json["steps"]] == ["rest"]
    again = mimucal("next", run, "--out", str(out))
    assert again.code == 2
    assert "--out" in again.err


def test_what_the_station_cannot_decide_is_said_and_nothing_is_written(
    run, answered, mimucal, tmp_path
):
    answered(10.0)
    out = tmp_path / "next.json"
    done = mimucal("next", run, "--out", str(out), "--json")
    assert done.code == 0
    assert (done.json["procedure"], done.json["minutes"], done.json["steps"]) == (None, None, [])
    assert "What would" in done.json["statement"]["en"]
    assert not out.exists()


def test_where_nothing_is_open_it_asks_what_to_tell_apart(run, mimucal, monkeypatch):
    monkeypatch.setattr(next_recording, "open_question", lambda *_: None)
    refused = mimucal("next", run)
    assert refused.code == 2
    assert "--for" in refused.err


def test_unusable_options_are_one_sentence_each(run, mimucal, tmp_path):
    for arguments in (
        ("--minutes", "0"), ("--minutes", "abc"), ("--station", str(tmp_path / "none.toml")),
        ("--procedure", str(tmp_path / "none.toml")), ("--for", "no_such_effect"),
    ):  # fmt: skip
        refused = mimucal("next", run, *arguments)
        assert refused.code == 2, arguments
        assert len(refused.err.strip().splitlines()) == 1
        assert json.dumps(refused.err)


@pytest.mark.parametrize(
    ("effects", "says"),
    [
        ("time_ofset", "time_offset"), ("Lever Arm", "lever_arm"), ("unnamed", "no such effect"),
        ("time_offset,time_offset", "twice"), ("", "--for is empty"), (" , ", "--for is empty"),
    ],
)  # fmt: skip
def test_what_is_no_effect_is_refused_before_any_work(run, mimucal, monkeypatch, effects, says):
    monkeypatch.setattr(next_recording, "open_question", _is_long)
    refused = mimucal("next", run, "--for", effects)
    assert refused.code == 2
    assert says in refused.err


def _is_long(*_: object) -> None:
    raise AssertionError("a sentence that could come at once comes after minutes of work")


def test_a_file_that_is_there_is_refused_before_any_work_and_stays(
    run, mimucal, monkeypatch, tmp_path
):
    monkeypatch.setattr(next_recording, "open_question", _is_long)
    out = tmp_path / "next.json"
    out.write_text("kept", encoding="utf-8")
    for taken in (out, tmp_path, tmp_path / "none" / "next.json"):
        refused = mimucal("next", run, "--out", str(taken))
        assert (refused.code, "AssertionError" in refused.err) == (2, False)
        assert str(taken) in refused.err
    monkeypatch.chdir(tmp_path)
    (tmp_path / "next-lever_arm.json").write_text("kept", encoding="utf-8")
    assert "already there" in mimucal("next", run, "--for", "lever_arm").err
    assert out.read_text(encoding="utf-8") == "kept"


def test_a_full_disk_leaves_no_half_procedure(
    run, answered, mimucal, monkeypatch,
    tmp_path
):  # fmt: skip
    answered(80.0)

    def full(path: Path, *_: object, **__: object) -> int:
        path.touch()
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    refused = mimucal("next", run, "--out", str(tmp_path / "next.json"))
    assert (refused.code, list(tmp_path.glob("*next*"))) == (2, [])


def test_the_base_is_a_procedure_by_its_name_or_a_file(run, answered, mimucal, tmp_path):
    answered(80.0)
    out = str(tmp_path / "next.json")
    assert mimucal("next", run, "--procedure", "jjf2003", "--out", out).code == 0
    refused = mimucal("next", run, "--procedure", "jjf2004", "--out", out + "2")
    assert (refused.code, "jjf2003" in refused.err) == (2, True)


def test_what_more_of_the_same_would_decide_is_said_with_its_minutes(run, answered, mimucal):
    answered(20.0)
    text = mimucal("next", run, "--json").json["statement"]["en"]
    assert int(re.findall(r"--minutes (\d+)", text)[0]) > 15  # min, that it may take by itself
    answered(0.0)
    text = mimucal("next", run, "--json").json["statement"]["en"]
    assert "--minutes" not in text
    assert "As far as the encoders of this table resolve its motion" in text


def test_runs_of_two_units_are_refused_in_one_sentence(home, run, ideal_run, mimucal):
    other = ideal_run(dwell=1.0)
    unit = other.manifest.unit.model_copy(update={"serial": "ANOTHER"})
    other = replace(other, manifest=other.manifest.model_copy(update={"unit": unit}))
    refused = mimucal("next", run, runs.add(other, Home(home))[0].id)
    assert refused.code == 2
    assert "ANOTHER" in refused.err
    assert len(refused.err.strip().splitlines()) == 1


# `mimucal simulate`: a recording that can be read, imported and explained with.


def test_simulation_of_a_clean_plant_reads_what_the_plant_read(mimucal, plant_clean, tmp_path):
    done = mimucal("simulate", plant_clean, "--out", tmp_path / "sim", "--json")
    assert (done.code, done.json["format"]) == (0, "mimu-simulate/1")
    assert done.json["assumed_ideal"] == []
    simulated, read = read_folder(tmp_path / "sim"), read_folder(plant_clean)
    assert len(simulated.imu) == done.json["rows"]
    miss = simulated.imu.stack(GYRO + ACCEL) - read.imu.stack(GYRO + ACCEL)[-done.json["rows"] :]
    held = [read.imu.rows(s.t_start, s.t_end) for s in read.manifest.segments if s.kind == "static"]
    means = np.array([miss[rows].mean(axis=0) for rows in held])
    assert np.abs(means[:, :3]).max() < 2e-4
    assert np.abs(means[:, 3:]).max() < 5e-3


def test_bad_calibration_is_one_sentence(mimucal, plant_clean, tmp_path):
    """Not there, not a result, not JSON."""
    order, wrong = tmp_path / "order.toml", tmp_path / "result.json"
    order.write_text('format = "mimu-order/1"\n', encoding="utf-8")
    wrong.write_text("{", encoding="utf-8")
    for named, says in (("nowhere", "no result"), (order, "mimu-order/1"), (wrong, "not JSON")):
        done = mimucal("simulate", plant_clean, "--calibration", named, "--out", tmp_path / "sim")
        assert done.code == 2
        assert done.err.strip().count("\n") == 0
        assert says in done.err
        assert not (tmp_path / "sim").exists()


def test_a_folder_that_is_taken_is_not_written_over(mimucal, plant_clean, tmp_path):
    (tmp_path / "kept").write_text("mine", encoding="utf-8")
    done = mimucal("simulate", plant_clean, "--out", tmp_path)
    assert done.code == 2
    assert "new folder" in done.err
    assert (tmp_path / "kept").read_text(encoding="utf-8") == "mine"
