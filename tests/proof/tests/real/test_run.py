"""The whole of it on one recording, in fresh processes, and its pages."""

import json
from pathlib import Path

import pytest
import typer

from schemas.base import Unusable
from schemas.recording import Recording
from storage.formats.folder import read_folder
from tests.proof import prove
from tests.proof.__main__ import main
from tests.proof.real import run as run_module
from tests.proof.real.cases import Hidden
from tests.proof.real.fact import Claim, Fact, Judged
from tests.proof.real.hand.measured import Measured
from tests.proof.real.hide import Size
from tests.proof.real.page import data, markdown, real_html
from tests.proof.real.pictures import Picture
from tests.proof.real.run import Results, explained, write
from tests.proof.real.score import Score
from tests.proof.text import bilingual


def test_recording_that_was_written_is_read_again(shaft: Recording, tmp_path: Path) -> None:
    write(shaft, tmp_path / "001")
    again = read_folder(tmp_path / "001")
    assert again.manifest.station == shaft.manifest.station
    assert set(again.streams()) == {"imu", "table"}
    assert (again.imu.t == shaft.imu.t).all()


@pytest.mark.rehearsal
def test_recordings_are_explained_by_number(tmp_path: Path, shared_real: Path) -> None:
    mems = read_folder(shared_real / "adi_mems_two_position")
    answers = explained({"mems": mems}, tmp_path, lambda done, of: None)
    assert "mains_pickup" in [each["effect"] for each in answers["mems"]["findings"]]
    assert [each.name for each in (tmp_path / "recordings").iterdir()] == ["001"]


@pytest.fixture
def results() -> Results:
    declared = Judged("time_offset 0.012 ± 0.0001 s", "right")
    fact = Fact(
        "delay",
        ("shaft",),
        bilingual("late <", "滞后"),
        (bilingual("phase", "相位"), bilingual("angle", "角度")),
        ("12 ms", "11.9 ms"),
        bilingual("whose", "来源"),
        lambda answer: declared,
    )
    claim = Claim(
        "shaft",
        bilingual("a line", "谱线"),
        "false",
        bilingual("gone", "消失"),
        lambda answer: True,
    )
    hidden = Hidden("shaft", "time_offset", Size(0.01, "s"))
    measured = Measured(0.01, 1e-4, "s")
    score = Score(hidden, ("time_offset",), True, measured, measured, 3.0, None)
    unseen = Hidden("shaft", "axis_tilt", Size(0.01, "rad"), bilingual("absorbed", "被吸收"))
    quiet = Score(unseen, (), False, None, None, 2.0, None)
    picture = Picture("<svg></svg>", bilingual("delay", "时延"))
    return Results(
        1, "test", ((fact, (declared,)),), ((claim, True),), (score, quiet), (picture,), 9.0, 8.0
    )


def test_page_and_tables_say_the_same_in_both_languages(results: Results) -> None:
    response = data(results)
    assert json.loads(json.dumps(response)) == response
    assert response["summary"]["hidden and visible: found, value right"] == "1 of 1"
    assert response["summary"]["doubtful claims that it makes now and are false"] == "1 of 1"
    html, plain = real_html(results), markdown(results)
    assert "late &lt;" in html
    assert "被吸收" in html
    assert "absorbed" in plain
    assert html.count("<svg") == 1
    assert "http" not in html
    for words in ("0.01 ± 0.0001 s", "found, value right", "rightly nothing new"):
        assert words in html
        assert words in plain


@pytest.mark.rehearsal
def test_command_writes_what_was_held(
    shared_real: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With answers that tell nothing, so that it takes seconds."""
    nothing = {"seconds": 1.0, "findings": []}
    monkeypatch.setattr(
        run_module, "explained", lambda asked, out, report: dict.fromkeys(asked, nothing)
    )
    prove.prove_real(shared_real, tmp_path / "out", 1)
    response = json.loads((tmp_path / "out/real.json").read_text())
    assert response["format"] == "mimu-prove-real/1"
    assert response["summary"]["  by hand, within 95 %"] == "9 of 9"
    assert response["summary"]["hidden and visible: found, value right"] == "0 of 9"
    outcomes = {each["outcome"] for each in response["hidden"]}
    assert outcomes == {"missed", "rightly nothing new"}
    assert (tmp_path / "out/real.html").read_text().count("<svg") == 9
    assert "| dropped_samples |" in (tmp_path / "out/real.md").read_text()


def test_folder_without_the_recordings_is_refused(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(Unusable, match="there is no recording ln100_two_position"):
        prove.prove_real(tmp_path / "empty", tmp_path / "out", 1)


def test_command_takes_the_folder_and_says_in_one_sentence_what_is_wrong(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(typer.Exit) as left:
        main(real=tmp_path, out=tmp_path / "out", as_json=True)
    assert left.value.exit_code == 2
    response = capsys.readouterr().err
    assert "there is no recording" in response
    assert response.strip().count("\n") == 0
