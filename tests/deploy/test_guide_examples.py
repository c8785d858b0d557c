"""Examples of the guides are files that the program reads."""

import re
import tomllib
from pathlib import Path

import pytest

from schemas.certificate import Laboratory
from schemas.equipment import EquipmentFile
from storage.formats import recordings
from storage.formats.convert import Changes
from storage.home import Home
from tasks.conformity import check_capabilities
from tasks.stages.imports.log import understand

GUIDE = Path("deploy/guide")
PARTY = {"name": "L", "name_zh": "实", "address": "a", "address_zh": "址"}


def examples(page: str, mark: str) -> list[str]:
    text = (GUIDE / page).read_text(encoding="utf-8")
    return [each for each in re.findall(r"```toml\n(.*?)```", text, re.DOTALL) if mark in each]


@pytest.mark.parametrize("number", [0, 1])
def test_the_standards_of_the_guide_go_into_the_register(number: int) -> None:
    example = examples("reminders.md", "[[equipment]]")[number]
    (standard,) = EquipmentFile.model_validate(tomllib.loads(example)).equipment
    assert standard.limits or standard.functions


def test_the_capabilities_of_the_guide_are_read() -> None:
    (example,) = examples("certificates.md", "[[capabilities]]")
    laboratory = Laboratory.model_validate({"party": PARTY} | tomllib.loads(example))
    assert len(laboratory.capabilities) == 2
    check_capabilities(laboratory.capabilities)


def test_the_table_and_the_protocol_of_the_guide_are_imported(tmp_path: Path) -> None:
    text = (GUIDE / "recordings.md").read_text(encoding="utf-8")
    table, protocol = re.findall(r"```csv\n(.*?)```", text, re.DOTALL)
    header, first, *_ = table.splitlines()
    rest = first.split(";", 1)[1]
    rows = [f"{10 * k};{rest}" for k in range(68_000)]
    (tmp_path / "log.csv").write_text("\n".join([header, *rows]), encoding="utf-8")
    (tmp_path / "protocol.csv").write_text(protocol, encoding="utf-8")
    shown = understand(
        tmp_path / "log.csv", Home(tmp_path), protocol=tmp_path / "protocol.csv", columns={},
        changes=Changes(),
    )  # fmt: skip
    assert [(s.kind, s.up, s.rate_deg_s) for s in shown.segments] == [
        ("static", "+z", None), ("static", "+z", None), ("static", "-z", None),
        ("rate", "+z", 100.0), ("rate", "+z", -100.0),
    ]  # fmt: skip
    assert shown.picture.read_text(encoding="utf-8").startswith("<svg")


def test_the_manifest_of_the_guide_is_read_as_a_recording(tmp_path: Path) -> None:
    text = (GUIDE / "recordings.md").read_text(encoding="utf-8")
    (manifest,) = re.findall(r"```json\n(.*?)```", text, re.DOTALL)
    (tmp_path / "manifest.json").write_text(manifest, encoding="utf-8")
    times = [f"{k / 10}" for k in range(100)]
    imu = ["t,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z", *(f"{t},0,0,0,0,0,9.8" for t in times)]
    table = ["t,outer_angle,inner_angle", *(f"{t},0,0" for t in times)]
    (tmp_path / "imu.csv").write_text("\n".join(imu))
    (tmp_path / "table.csv").write_text("\n".join(table))
    recording = recordings.read(tmp_path)
    assert [s.name for s in recording.manifest.segments or ()] == ["position_+z_000", "rate_z_+100"]
