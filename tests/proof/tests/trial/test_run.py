"""A whole trial of two recordings, by the command."""

import json
import os
import re
from pathlib import Path

import pytest

from schemas.base import Unusable
from tests.proof import prove
from tests.proof.trial.draw import Drawn


@pytest.mark.rehearsal
def test_trial_is_held_and_leaves_its_evidence(
    two_cases: list[Drawn], tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.setattr(prove, "draw", lambda seed, short: two_cases)
    monkeypatch.setattr(os, "cpu_count", lambda: 1)  # a second process would import all again
    folder = tmp_path / "trial"
    prove.run_prove(seed=7, short=True, out=folder, as_json=True)
    response = json.loads(capsys.readouterr().out)
    assert response == json.loads((folder / "evidence.json").read_text())
    assert response["format"] == "mimu-prove/2"
    assert [case["effects"] for case in response["cases"]] == [[], ["temperature_bias"]]
    assert response["totals"]["one effect, z 60"]["detected"]["share"] == 1.0
    assert response["cases"][1]["gap"]["closed"] > 0.5
    cost = response["cases"][1]["cost"]
    assert cost["after"] < cost["before"] / 3.0
    answer = json.loads((folder / "answers/0002/answer.json").read_text())
    assert [one["effect"] for one in answer["findings"]] == response["cases"][1]["names"]
    assert "| temperature_bias |" in (folder / "evidence.md").read_text()
    page = (folder / "evidence.html").read_text()
    assert page.count("<svg") == 5
    assert response["seals_sha256"] in page
    assert "make prove --seed 7 --short" in page
    assert len((folder / "headline.svg").read_text()) < 40_000
    assert "http" not in re.sub(r'xmlns(:xlink)?="[^"]*"', "", page)


def test_folder_in_use_is_refused(tmp_path: Path) -> None:
    (tmp_path / "kept.txt").write_text("mine")
    with pytest.raises(Unusable, match="is not empty"):
        prove.run_prove(seed=1, short=True, out=tmp_path, as_json=False)
    with pytest.raises(Unusable, match="cannot be used"):
        prove.run_prove(seed=1, short=True, out=tmp_path / "kept.txt", as_json=False)
