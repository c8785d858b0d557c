"""Workbooks as spreadsheet programs write them: shared texts, references, dates by style."""

import zipfile
from pathlib import Path

import pytest

from schemas.base import Unusable
from storage.formats.logger.tables.xlsx import read

NAME = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
SHEET = (
    '<row r="1"><c r="A1" t="s"><v>0</v></c><c r="C1" t="s"><v>1</v></c></row>'
    '<row r="2"><c r="A2" s="1"><v>46083.5000115741</v></c><c r="B2"><v>1.5</v></c>'
    '<c r="C2" t="str"><f>1+1</f><v>2</v></c></row>'
    '<row r="3"><c r="A3" s="2"><v>0.25</v></c><c r="C3" t="b"><v>1</v></c></row>'
)


def book(path: Path, sheet: str) -> Path:
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("xl/sharedStrings.xml", f'<sst xmlns="{NAME}"><si><t>Time</t></si>'
                      "<si><r><t>gyro</t></r><r><t> x</t></r></si></sst>")  # fmt: skip
        file.writestr("xl/styles.xml", f'<styleSheet xmlns="{NAME}"><numFmts><numFmt '
                      'numFmtId="164" formatCode="yyyy-mm-dd hh:mm:ss.000"/></numFmts><cellXfs>'
                      '<xf numFmtId="0"/><xf numFmtId="164"/><xf numFmtId="21"/></cellXfs>'
                      "</styleSheet>")  # fmt: skip
        file.writestr("xl/worksheets/sheet1.xml", f'<worksheet xmlns="{NAME}"><sheetData>'
                      f"{sheet}</sheetData></worksheet>")  # fmt: skip
    return path


def test_texts_gaps_formulas_and_dates_are_read(tmp_path):
    rows = [line.split("\t") for line in read(book(tmp_path / "log.xlsx", SHEET)).lines]
    assert rows == [
        ["Time", "", "gyro x"],
        ["2026-03-02 12:00:01.000002", "1.5", "2"],
        ["06:00:00.000000", "", "1"],
    ]


def test_what_is_no_workbook_is_one_sentence(tmp_path):
    (tmp_path / "log.xlsx").write_text("t,gx")
    with pytest.raises(Unusable, match="no xlsx workbook"):
        read(tmp_path / "log.xlsx")
    with pytest.raises(Unusable, match="no sheet holds a table"):
        read(book(tmp_path / "empty.xlsx", ""))
