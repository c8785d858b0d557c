"""A rough trial, held with engines that answer by rote."""

from collections.abc import Callable
from pathlib import Path

import pytest

from schemas.base import Unusable
from tests.proof.tests.trial.answers import finding
from tests.proof.trial.rough import run
from tests.proof.trial.rough.draw import RoughDrawn
from tests.proof.trial.rough.engine import explain_rough
from tests.proof.trial.rough.score import score_rough

Engines = Callable[..., Path]


def silent(done: int, of: int) -> None:
    """No progress is shown."""


def test_engine_answers_each_recording_once_and_a_failure_is_kept(
    sealed_rough: Path, engine: Engines, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", "/another/checkout")
    answers = sealed_rough / "answers-own"
    explain_rough(sealed_rough, answers, engine(finding("bias_step"), fails_on="0001"), silent)
    control, stepped = score_rough(sealed_rough, answers)
    assert control.failed == "it cannot"
    assert stepped.failed is None
    assert stepped.names == ("bias_step",)
    assert stepped.left_over == {"gyro_x": 1.2}
    explain_rough(sealed_rough, answers, engine(name="later"), silent)
    assert score_rough(sealed_rough, answers)[1].names == ("bias_step",)


def test_no_explanation_begins_after_the_minutes(sealed_rough: Path, engine: Engines) -> None:
    answers = sealed_rough / "answers-own"
    answers.mkdir()
    explain_rough(sealed_rough, answers, engine(), silent, minutes=0.0)
    assert score_rough(sealed_rough, answers) == []


def test_changed_truth_is_refused(sealed_rough: Path, engine: Engines) -> None:
    answers = sealed_rough / "answers-own"
    explain_rough(sealed_rough, answers, engine(), silent)
    (sealed_rough / "sealed/0001/trial.json").write_text("{}")
    with pytest.raises(Unusable, match="is not what was sealed"):
        score_rough(sealed_rough, answers)


@pytest.mark.rehearsal
def test_two_engines_stand_beside_one_another_on_the_same_recordings(
    two_rough: list[RoughDrawn],
    engine: Engines,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(run, "draw_rough", lambda seed, short: two_rough)
    out = tmp_path / "held"
    run.run_rough(1, True, out, engine(finding("bias_step"), name="new"), None)
    seals = (out / "seals.txt").read_text()
    run.run_rough(1, True, out, engine(finding("hysteresis"), name="old"), None)
    assert (out / "seals.txt").read_text() == seals
    page = (out / "rough.html").read_text()
    assert "<h2>new</h2>" in page
    assert "<h2>old</h2>" in page
    assert "Rough recordings, old: 2" in capsys.readouterr().out
    with pytest.raises(Unusable, match="holds another trial"):
        run.run_rough(2, True, out, engine(name="third"), None)
    with pytest.raises(Unusable, match="is not there"):
        run.run_rough(1, True, out, tmp_path / "nothing", None)
