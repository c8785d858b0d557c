"""What is handed out tells nothing, and what is sealed stays as it was."""

import hashlib
import json
from pathlib import Path

import pytest

from schemas.base import Unusable
from storage.formats.folder import read_folder
from tests.proof.plant.case import Case, EffectCall
from tests.proof.trial.seal import Drawn, check_seals, set_seals, sized


def test_recording_is_handed_out_without_its_truth(sealed: Path) -> None:
    handed = sorted(path.name for path in (sealed / "recordings" / "0002").iterdir())
    assert handed == ["environment.parquet", "imu.parquet", "manifest.json", "table.parquet"]
    assert "temperature_bias" not in (sealed / "recordings/0002/manifest.json").read_text()
    assert read_folder(sealed / "recordings" / "0002").imu.columns.keys() >= {"gyro_x", "accel_z"}


def test_truth_is_sealed_with_the_visibility_that_was_asked(sealed: Path) -> None:
    trial = json.loads((sealed / "sealed/0002/trial.json").read_text())
    assert trial["z"]["temperature_bias"] == pytest.approx(60.0, rel=0.03)
    assert trial["floor"] > 6.0  # a parameter of each channel at the least
    value, U = trial["certificate"]["values"]["accel_bias x"]
    assert 0.0 < U < abs(value)
    truth = json.loads((sealed / "sealed/0002/truth.json").read_text())
    assert list(truth["effects"]) == ["temperature_bias"]


def test_seals_are_the_sha256_of_every_sealed_file(sealed: Path) -> None:
    lines = (sealed / "seals.txt").read_text().splitlines()
    assert len(lines) == 6  # three files of each case
    for digest, name in (line.split("  ") for line in lines):
        assert hashlib.sha256((sealed / name).read_bytes()).hexdigest() == digest
    check_seals(sealed)


def test_a_changed_a_lost_and_a_new_file_break_the_seal(sealed: Path) -> None:
    truth = sealed / "sealed/0001/truth.json"
    text = truth.read_text()
    truth.write_text(text + " ")
    with pytest.raises(Unusable, match=r"0001/truth\.json is not what was sealed"):
        check_seals(sealed)
    truth.unlink()
    with pytest.raises(Unusable, match=r"0001/truth\.json"):
        check_seals(sealed)
    truth.write_text(text)
    check_seals(sealed)
    (sealed / "sealed/0003").mkdir()
    (sealed / "sealed/0003/truth.json").write_text("{}")
    with pytest.raises(Unusable, match="0003"):
        check_seals(sealed)


def test_seals_have_a_seal_of_their_own(sealed: Path) -> None:
    before = set_seals(sealed)
    assert before == hashlib.sha256((sealed / "seals.txt").read_bytes()).hexdigest()
    (sealed / "sealed/0001/truth.json").write_text("{}")
    assert set_seals(sealed) != before


@pytest.mark.rehearsal
def test_effect_that_the_procedure_cannot_have_is_played_on_three_axes() -> None:
    square = EffectCall(name="axis_nonorthogonality")
    case = Case(seed=3, procedure="single_axis", dwell_s=5.0, effects=(square,))
    played = sized(Drawn(number=1, kind="single", case=case, z=30.0))
    assert played.procedure == "three_axis"
    assert [call.name for call in played.effects] == ["axis_nonorthogonality"]
