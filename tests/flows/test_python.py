"""`import mimucal`: the README's example as it stands, and what it refuses."""

import re
from pathlib import Path
from typing import Any

import mimucal
import numpy as np
import pytest

from storage.formats.content import write_columns

README = Path(__file__).parents[2] / "README.md"
EXAMPLE = re.compile(r"```python\n(.*?)```", re.DOTALL)


@pytest.fixture
def folder(ideal_run, tmp_path) -> Path:
    """A recording of an exact unit, as a folder."""
    write_columns(ideal_run(noise=1e-5), tmp_path / "recording")
    return tmp_path / "recording"


def test_the_example_of_the_readme_runs_as_it_stands(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder.parent)
    (example,) = EXAMPLE.findall(README.read_text(encoding="utf-8"))
    assert len(example.splitlines()) <= 22
    names: dict[str, Any] = {}
    exec(example, names)
    assert names["table"].shape == (42, 7)
    assert "gyro_scale_factor" in capsys.readouterr().out
    assert list(folder.parent.iterdir()) == [folder]  # neither a home nor anything else was made


def test_a_unit_with_terms_reads_what_their_equations_say(folder):
    recording = mimucal.open(folder)
    ideal = mimucal.simulate(recording)
    other = mimucal.simulate(recording, {"gyro_bias": {"x": 0.01}})
    change = (other - ideal).to_numpy()
    known = np.isfinite(change).all(axis=1)
    assert known.any()
    assert change[known] == pytest.approx(np.tile([0.01, 0, 0, 0, 0, 0], (known.sum(), 1)))


def test_names_that_the_catalogue_lacks_are_refused_all_at_once(folder):
    values = {"gyro_bias": {"q": 1.0}, "weather": {"wind": 1.0}}
    with pytest.raises(mimucal.Unusable, match=r"no gyro_bias\.q, weather\.wind; see"):
        mimucal.simulate(mimucal.open(folder), values)


def test_what_is_no_recording_is_refused_in_one_sentence(tmp_path):
    with pytest.raises(mimucal.Unusable, match=r"holds no recording: manifest\.json is missing"):
        mimucal.open(tmp_path)
