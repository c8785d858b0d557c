"""Examples of the guides are files that the program reads."""

import re
import string
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from schemas.certificate import Laboratory
from schemas.laboratory import EquipmentFile
from storage.formats import recordings
from storage.formats.convert import Changes
from storage.home import Home
from tasks.certificate.mandatory import CLAUSE_8, MANDATORY
from tasks.conformity import check_capabilities
from tasks.stages.logger_table import understand

GUIDE = Path("deploy/guide")
PARTY = {"name": "L", "name_zh": "实", "address": "a", "address_zh": "址"}


def examples(page: str, mark: str) -> list[str]:
    text = (GUIDE / page).read_text(encoding="utf-8")
    return [each for each in re.findall(r"```toml\n(.*?)```", text, re.DOTALL) if mark in each]


@pytest.mark.parametrize("number", [0, 1])
def test_the_standards_of_the_guide_go_into_the_register(number):
    example = examples("reminders.md", "[[equipment]]")[number]
    (standard,) = EquipmentFile.model_validate(tomllib.loads(example)).equipment
    assert standard.limits or standard.functions


def test_the_capabilities_of_the_guide_are_read():
    (example,) = examples("certificates.md", "[[capabilities]]")
    laboratory = Laboratory.model_validate({"party": PARTY} | tomllib.loads(example))
    assert len(laboratory.capabilities) == 2
    check_capabilities(laboratory.capabilities)


def test_the_table_and_the_protocol_of_the_guide_are_imported(tmp_path):
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


def test_the_manifest_of_the_guide_is_read_as_a_recording(tmp_path):
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


# The page that holds certificates to clause 8 and ISO/IEC 17025, 7.8, says what the data say.

PAGE = Path("deploy/guide/clause-8.md")
Row = tuple[str, tuple[str, ...], str]


def rows() -> Iterator[Row]:
    """Clause, fields and test of every line."""
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if re.match(r"\| (8|7\.8)", line):
            yield cells[0], tuple(filter(None, cells[1].split(", "))), cells[-1]


def fields(prefix: str) -> set[tuple[str, str]]:
    return {(clause, name) for clause, names, _ in rows() for name in names
            if clause.startswith(prefix)}  # fmt: skip


def letters(prefix: str) -> set[str]:
    return {clause.removeprefix(prefix) for clause, _, _ in rows() if clause.startswith(prefix)}


def test_every_field_of_the_data_stands_on_the_page_under_its_letter_and_no_other():
    assert fields("8 ") == {(f"8 {each.letter}", each.name) for each in CLAUSE_8}
    assert {tuple(each.letter for each in listed) for listed in MANDATORY.values()} == {
        tuple(each.letter for each in CLAUSE_8)
    }


def test_every_field_stands_under_its_clause_of_17025():
    asked = set()
    for each in CLAUSE_8:
        first, *others = each.iso.split(", ")
        clause = first.partition(" ")[0]
        asked |= {(first, each.name)} | {(f"{clause} {other}", each.name) for other in others}
    assert fields("7.8") == asked


@pytest.mark.parametrize(("clause", "last"), [("8 ", "l"), ("7.8.2.1 ", "p"), ("7.8.4.1 ", "f")])
def test_no_line_of_a_clause_is_left_out(clause, last):
    known = string.ascii_lowercase[: string.ascii_lowercase.index(last) + 1]
    assert letters(clause) == {f"{letter})" for letter in known}


def test_the_tests_that_it_names_are_there():
    every = "\n".join(path.read_text(encoding="utf-8") for path in Path("tests").rglob("test_*.py"))
    named = {test for _, _, test in rows()} - {""}
    assert [test for test in sorted(named) if f"def {test}(" not in every] == []
    untested = {clause for clause, _, test in rows() if not test}
    assert untested == {"7.8.2.1 p)", "7.8.4.1 f)"}  # which no certificate of this program has
