"""`mimucal next`: the procedure that it writes is one that `acquire` takes; refusals are said."""

import errno
import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from schemas.procedure import EnvironmentLimits, Position, Procedure
from schemas.recording import Recording
from storage import settings
from storage.catalogue import runs
from storage.home import Home
from tasks.experiment import abilities, separation
from tasks.experiment.choose import Choice, Experiment
from tasks.experiment.open_question import OpenQuestion
from tasks.stages import next_recording

PROCEDURE = Procedure(
    name="decide", title="t", title_zh="t", standard="other", warm_up_s=0.0, settle_s=0.1,
    environment=EnvironmentLimits(temperature_degc=(15, 25), humidity_percent=(20, 80)),
    move_rate_deg_s=60, acceleration_deg_s2=100,
    steps=(Position(name="rest", item="i", up="+z", angles_deg=(0, 0, 0), dwell_s=2.0),),
)  # fmt: skip


@pytest.fixture
def run(home: Path, ideal_run: Callable[..., Recording]) -> str:
    return runs.add(ideal_run(dwell=1.0), Home(home))[0].id


@pytest.fixture
def answered(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """The engine with a known answer: the chi-squared that its procedure shows."""

    def answer(left: float, *names: str) -> None:
        fit = SimpleNamespace(blocks=None, noises=())
        names = names or ("time_offset", "bandwidth")
        question = OpenQuestion(names, {}, {}, fit)  # type: ignore[arg-type]
        monkeypatch.setattr(next_recording, "rivals_of", lambda *_: {})
        monkeypatch.setattr(next_recording, "open_question", lambda *_: question)
        monkeypatch.setattr(separation.UnitNoise, "of", lambda *_: None)
        able = SimpleNamespace(chamber=None)
        monkeypatch.setattr(abilities.Abilities, "of_recording", lambda *_: able)
        least = Choice(PROCEDURE, 1.5, left, 30.0, left)
        monkeypatch.setattr(Experiment, "shortest", lambda *_: least)
        typical = replace(least, expected=1.25 * left)
        monkeypatch.setattr(Experiment, "judged", lambda *_: typical)
        monkeypatch.setattr(Experiment, "left_by", lambda *_: 2.0)

    return answer


def test_the_recording_that_decides_is_a_procedure_that_acquire_takes(
    run: str, answered: Callable[[float], None], mimucal, tmp_path: Path
) -> None:
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
    run: str, answered: Callable[[float], None], mimucal, tmp_path: Path
) -> None:
    answered(10.0)
    out = tmp_path / "next.json"
    done = mimucal("next", run, "--out", str(out), "--json")
    assert done.code == 0
    assert (done.json["procedure"], done.json["minutes"], done.json["steps"]) == (None, None, [])
    assert "What would" in done.json["statement"]["en"]
    assert not out.exists()


def test_where_nothing_is_open_it_asks_what_to_tell_apart(
    run: str, mimucal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(next_recording, "open_question", lambda *_: None)
    refused = mimucal("next", run)
    assert refused.code == 2
    assert "--for" in refused.err


def test_unusable_options_are_one_sentence_each(run: str, mimucal, tmp_path: Path) -> None:
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
def test_what_is_no_effect_is_refused_before_any_work(
    run: str, mimucal, monkeypatch: pytest.MonkeyPatch, effects: str, says: str
) -> None:
    monkeypatch.setattr(next_recording, "open_question", _is_long)
    refused = mimucal("next", run, "--for", effects)
    assert refused.code == 2
    assert says in refused.err


def _is_long(*_: object) -> None:
    raise AssertionError("a sentence that could come at once comes after minutes of work")


def test_a_file_that_is_there_is_refused_before_any_work_and_stays(
    run: str, mimucal, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
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
    run: str, answered: Callable[[float], None], mimucal, monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:  # fmt: skip
    answered(80.0)

    def full(path: Path, *_: object, **__: object) -> int:
        path.touch()
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    refused = mimucal("next", run, "--out", str(tmp_path / "next.json"))
    assert (refused.code, list(tmp_path.glob("*next*"))) == (2, [])


def test_the_base_is_a_procedure_by_its_name_or_a_file(
    run: str, answered: Callable[[float], None], mimucal, tmp_path: Path
) -> None:
    answered(80.0)
    out = str(tmp_path / "next.json")
    assert mimucal("next", run, "--procedure", "jjf2003", "--out", out).code == 0
    refused = mimucal("next", run, "--procedure", "jjf2004", "--out", out + "2")
    assert (refused.code, "jjf2003" in refused.err) == (2, True)


def test_two_runs_of_a_pair_are_asked_in_turn(
    run: str, answered: Callable[[float], None], mimucal, tmp_path: Path
) -> None:
    answered(80.0)
    assert mimucal("next", run, run, "--out", str(tmp_path / "n.json")).code == 0


def test_what_more_of_the_same_would_decide_is_said_with_its_minutes(
    run: str, answered: Callable[[float], None], mimucal
) -> None:
    answered(20.0)
    text = mimucal("next", run, "--json").json["statement"]["en"]
    assert int(re.findall(r"--minutes (\d+)", text)[0]) > 15  # min, that it may take by itself
    answered(0.0)
    text = mimucal("next", run, "--json").json["statement"]["en"]
    assert "--minutes" not in text
    assert "As far as the encoders of this table resolve its motion" in text


def test_runs_of_two_units_are_refused_in_one_sentence(
    home: Path, run: str, ideal_run: Callable[..., Recording], mimucal
) -> None:
    other = ideal_run(dwell=1.0)
    unit = other.manifest.unit.model_copy(update={"serial": "ANOTHER"})
    other = replace(other, manifest=other.manifest.model_copy(update={"unit": unit}))
    refused = mimucal("next", run, runs.add(other, Home(home))[0].id)
    assert refused.code == 2
    assert "ANOTHER" in refused.err
    assert len(refused.err.strip().splitlines()) == 1
