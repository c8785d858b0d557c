"""The page that holds certificates to clause 8 and ISO/IEC 17025, 7.8, says what the data say."""

import re
import string
from collections.abc import Iterator
from pathlib import Path

import pytest

from tasks.certificate.mandatory import CLAUSE_8, MANDATORY

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


def test_every_field_of_the_data_stands_on_the_page_under_its_letter_and_no_other() -> None:
    assert fields("8 ") == {(f"8 {each.letter}", each.name) for each in CLAUSE_8}
    assert {tuple(each.letter for each in listed) for listed in MANDATORY.values()} == {
        tuple(each.letter for each in CLAUSE_8)
    }


def test_every_field_stands_under_its_clause_of_17025() -> None:
    asked = set()
    for each in CLAUSE_8:
        first, *others = each.iso.split(", ")
        clause = first.partition(" ")[0]
        asked |= {(first, each.name)} | {(f"{clause} {other}", each.name) for other in others}
    assert fields("7.8") == asked


@pytest.mark.parametrize(("clause", "last"), [("8 ", "l"), ("7.8.2.1 ", "p"), ("7.8.4.1 ", "f")])
def test_no_line_of_a_clause_is_left_out(clause: str, last: str) -> None:
    known = string.ascii_lowercase[: string.ascii_lowercase.index(last) + 1]
    assert letters(clause) == {f"{letter})" for letter in known}


def test_the_tests_that_it_names_are_there() -> None:
    every = "\n".join(path.read_text(encoding="utf-8") for path in Path("tests").rglob("test_*.py"))
    named = {test for _, _, test in rows()} - {""}
    assert [test for test in sorted(named) if f"def {test}(" not in every] == []
    untested = {clause for clause, _, test in rows() if not test}
    assert untested == {"7.8.2.1 p)", "7.8.4.1 f)"}  # which no certificate of this program has
