"""Dashes, minus signs and equation numbers in both languages."""

import pytest

from schemas.text import Statement
from tasks.words.typography import clause, typeset


@pytest.mark.parametrize(
    ("written", "zh", "en"),
    [
        ("JJF 2003-2022, 7.2.1.2 eq. (3)-(5)", "7.2.1.2 式(3)～式(5)", "7.2.1.2 eq. (3)–(5)"),
        ("7.2.5.2 eq. (12), (13)", "7.2.5.2 式(12)、式(13)", "7.2.5.2 eq. (12), (13)"),
        ("5.2, list under eq. (2)", "5.2 式(2)下列表", "5.2, list under eq. (2)"),
        ("Appendix B, 3", "附录 B 第 3 项", "Appendix B, 3"),
        ("JJF 1536-2015, 7.2", "JJF 1536—2015，7.2", "JJF 1536-2015, 7.2"),
        ("nobody.knows", "nobody.knows", "nobody.knows"),
    ],
)
def test_a_clause_reads_as_each_language_writes_it(written: str, zh: str, en: str) -> None:
    assert clause(written, "JJF 2003-2022") == Statement(en=en, zh=zh)


def test_minus_signs_are_real_and_names_and_dates_stay_as_they_are() -> None:
    line = "static_-x (rate_x_-300) of 2026-11-05: -x up reads -9.8 m/s² (-60, +30 deg/s), JJF 1-2"
    assert typeset(line, "en") == (
        "static_-x (rate_x_-300) of 2026-11-05: −x up reads −9.8 m/s² (−60, +30 °/s), JJF 1-2"
    )


def test_chinese_has_its_own_range_and_dash() -> None:
    assert (
        typeset("JJF 2003-2022 要求 7~11 个，按 eq. (4)", "zh")
        == "JJF 2003—2022 要求 7～11 个，按 式(4)"
    )


def test_no_line_breaks_within_a_percentage() -> None:
    assert typeset("false rejection < 0.1 %, of 3 items", "en") == (
        "false rejection <\u00a00.1\u00a0%, of 3 items"
    )
