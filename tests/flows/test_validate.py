"""`mimucal validate`: a study too small to show anything does not replace the record."""

import pytest

from flows.validate import run_validate
from schemas.base import Unusable
from tasks.validation.coverage import MIN_UNITS


def test_a_small_study_leaves_the_record_of_the_home_alone(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("MIMUCAL_HOME", str(tmp_path))
    kept = tmp_path / "validation.json"
    kept.write_text("{}", encoding="utf-8")
    with pytest.raises(Unusable, match="--out"):
        run_validate(MIN_UNITS - 1, 1, None, as_json=True)
    assert kept.read_text(encoding="utf-8") == "{}"
