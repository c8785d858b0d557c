"""How a result and its uncertainty are written down (JJF 1059.1)."""

import math
from decimal import ROUND_HALF_EVEN, Context, Decimal

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from schemas.text import Statement
from tasks.words.numbers import (
    clause,
    column,
    moment,
    multiple,
    percent,
    plain,
    probability,
    quantities,
    quantity,
    rough_quantity,
    round_like,
    round_up,
    typeset,
)

THREE_DIGITS = Context(prec=3, rounding=ROUND_HALF_EVEN)  # of decimals: a binary 1.645 is no tie
HALF_OF_U_C = 0.005  # half the last of three digits, at the most
uncertainties = st.floats(1e-15, 1e9)
values = st.floats(-1e6, 1e6)


def number(text: str | None, exponent: int = 0) -> Decimal:
    assert text is not None
    return Decimal(text.replace("−", "-")).scaleb(exponent)


@pytest.mark.parametrize(
    ("uncertainty", "printed"),
    [
        (4.23e-4, "4.3e-4"),  # JJF 2003 A.1.4
        (5.36e-4, "5.4e-4"),  # JJF 2003 A.2.4, there with three digits
        (1.005e-2, "1.1e-2"),  # JJF 2003 A.3.4
        (4.3e-4, "4.3e-4"),  # a double a little off 4.3e-4 is still 4.3e-4
        (3 * 1.1e-4, "3.3e-4"),
        (0.1 + 0.2, "0.30"),
        (9.96e-4, "1.0e-3"),
        (99.1, "1.0e2"),
        (0.0, "0.0"),
        (2 * 1.0004e-4, "2.0e-4"),  # u_c = 1.00e-4
        (4.403e-4, "4.4e-4"),  # JJF 1536 A.2: u_c = 2.20e-4
    ],
)
def test_published_uncertainties_are_rounded_up_to_two_digits(uncertainty, printed):
    assert round_up(uncertainty) == Decimal(printed)


@pytest.mark.parametrize("nonsense", [-1e-9, math.inf, math.nan])
def test_an_uncertainty_that_cannot_be_one_is_refused(nonsense):
    with pytest.raises(ValueError, match="finite number"):
        round_up(nonsense)


@given(uncertainties)
def test_rounded_uncertainty_has_two_digits_and_is_never_noticeably_smaller(U):
    rounded = round_up(U)
    assert len(rounded.as_tuple().digits) == 2
    assert float(rounded) >= U * (1 - HALF_OF_U_C)
    assert float(rounded) <= U * 1.1 * (1 + HALF_OF_U_C)


@given(uncertainties, st.floats(1.5, 13.0))
def test_only_the_rounding_of_the_combined_uncertainty_makes_a_printed_one_smaller(u_c, k):
    assert float(round_up(k * u_c, k)) >= k * float(THREE_DIGITS.create_decimal(repr(u_c))) * (
        1 - 1e-9
    )


@given(uncertainties)
def test_rounding_a_rounded_uncertainty_changes_nothing(U):
    assert round_up(float(round_up(U))) == round_up(U)


@given(values, st.floats(1e-9, 1e3))
def test_value_moves_by_at_most_half_of_the_last_place(value, U):
    rounded = round_up(U)
    place = Decimal((0, (1,), rounded.as_tuple().exponent))
    assert abs(round_like(value, rounded) - Decimal(repr(value))) <= place / 2


def test_value_is_rounded_half_even():
    assert [str(round_like(v, Decimal("0.10"))) for v in (0.125, 0.135, -0.125)] == [
        "0.12",
        "0.14",
        "-0.12",
    ]


def test_a_value_that_rounds_to_zero_has_no_sign():
    assert column([-1e-9], [1e-3]).values == ("0.0000",)


def test_plain_decimals_where_they_are_readable():
    made = column([1.000234567, 0.99991, -1.0], [4.23e-4, 1.2e-5, 4.3e-4])
    assert made.exponent == 0
    assert made.values == ("1.00023", "0.999910", "−1.00000")
    assert made.uncertainties == ("0.00043", "0.000012", "0.00043")


def test_small_numbers_share_one_power_of_ten():
    made = column([3.124e-5, -1.2e-7], [1.24e-7, 1.31e-8])
    assert made.exponent == -6
    assert made.values == ("31.24", "−0.120")
    assert made.uncertainties == ("0.13", "0.014")


def test_large_uncertainties_show_no_digit_that_is_not_significant():
    made = column([1234567.0], [12345.0])
    assert (made.exponent, made.values, made.uncertainties) == (6, ("1.235",), ("0.013",))


def test_a_null_stays_null_beside_numbers():
    made = column([None, 0.5, math.nan], [None, 0.01, 0.01])
    assert made.values == (None, "0.500", None)
    assert made.uncertainties == (None, "0.010", "0.010")
    assert column([None], [None]).exponent == 0


def test_a_value_without_uncertainty_keeps_six_digits():
    assert column([0.123456789, 0.5], [None, 0.0]).values == ("0.123457", "0.5")


@given(st.lists(st.tuples(values, uncertainties), min_size=1, max_size=6))
def test_column_says_what_rounding_says(rows):
    assume(all(value == 0 or abs(value) > 1e-12 for value, _ in rows))
    made = column([v for v, _ in rows], [U for _, U in rows])
    for (value, U), shown, U_shown in zip(rows, made.values, made.uncertainties, strict=True):
        assert "e" not in f"{shown}{U_shown}".lower()
        assert number(shown, made.exponent) == round_like(value, round_up(U))
        assert number(U_shown, made.exponent) == round_up(U)


# Quantities are printed so that a person can read them, whatever their size.


@pytest.mark.parametrize(
    ("value", "U", "unit", "shown"),
    [
        (9.66, 0.4, "deg/h", "(9.66 ± 0.40) °/h"),
        (0.00268333, 0.000111, "deg/s", "(9.66 ± 0.40) °/h"),
        (np.radians(1.5), np.radians(0.2), "rad/s", "(1.50 ± 0.20) °/s"),
        (-4.5e-4, 2.4e-5, "rad", "(−450 ± 24) µrad"),
        (3.2e-12, 4e-13, "s", "(0.00320 ± 0.00040) ns"),
        (0.25, 0.01, "m", "(250 ± 10) mm"),
        (1.5e9, 3e7, "1", "(1.500 ± 0.030)×10⁹"),
        (2.1e-6, 1e-7, "(rad/s)/(m/s2)^2", "(120.3 ± 5.8)×10⁻⁶ (°/s)/(m/s²)²"),
        (0.0, 3e-8, "1", "(0 ± 30)×10⁻⁹"),
        (12.0, 0.0, "deg/s", "12.0 °/s"),
        (-0.51, 0.11, "m/s2", "(−0.51 ± 0.11) m/s²"),
        (4e-4, 3e-4, "m", "(0.40 ± 0.30) mm"),
        (1e-5, 2.0, "deg/s", "(0.0 ± 2.0) °/s"),
    ],
)
def test_numbers_of_every_size_are_readable(value, U, unit, shown):
    assert quantity(value, U, unit) == shown


def test_values_with_one_uncertainty_share_unit_and_places():
    made = quantities([0.0121, 0.0001], 0.0003, "m/s2")
    assert (made.values, made.uncertainties) == (("12.10", "0.10"), ("0.30", "0.30"))
    assert made.unit == "mm/s²"
    assert made.text(1) == "(0.10 ± 0.30) mm/s²"


def test_a_value_without_an_uncertainty_has_three_digits_in_a_unit_of_its_size():
    assert rough_quantity(0.01134, "s") == "11.3 ms"
    assert rough_quantity(-0.97, "1") == "−0.97"
    assert rough_quantity(np.radians(0.0527), "rad/s") == "0.0527 °/s"


def test_an_instant_of_a_long_run_is_a_whole_second():
    assert [moment(t) for t in (12.34, 1300.93, 1.6e9 + 0.4)] == ["12.3", "1301", "1600000000"]


def test_what_has_no_value_is_not_printed():
    made = quantities([None, None], None, "1")
    assert made.values == (None, None)
    assert made.unit == ""


def test_shares_probabilities_and_multiples_are_short():
    assert [percent(share) for share in (0.62, 0.001, 0.0)] == ["62 %", "< 1 %", "0 %"]
    assert [probability(p) for p in (0.0, 0.41)] == ["p < 10⁻¹²", "p = 0.41"]
    assert [multiple(ratio) for ratio in (-40.0, 551.2, 2e7)] == ["−40.0", "+551", "+2×10⁷"]
    assert [plain(number) for number in (149576.2, -3.2, 1e7)] == ["149576", "−3.2", "1×10⁷"]


# Dashes, minus signs and equation numbers in both languages.


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
def test_a_clause_reads_as_each_language_writes_it(written, zh, en):
    assert clause(written, "JJF 2003-2022") == Statement(en=en, zh=zh)


def test_minus_signs_are_real_and_names_and_dates_stay_as_they_are():
    line = "static_-x (rate_x_-300) of 2026-11-05: -x up reads -9.8 m/s² (-60, +30 deg/s), JJF 1-2"
    assert typeset(line, "en") == (
        "static_-x (rate_x_-300) of 2026-11-05: −x up reads −9.8 m/s² (−60, +30 °/s), JJF 1-2"
    )


def test_chinese_has_its_own_range_and_dash():
    assert (
        typeset("JJF 2003-2022 要求 7~11 个，按 eq. (4)", "zh")
        == "JJF 2003—2022 要求 7～11 个，按 式(4)"
    )


def test_no_line_breaks_within_a_percentage():
    assert typeset("false rejection < 0.1 %, of 3 items", "en") == (
        "false rejection <\u00a00.1\u00a0%, of 3 items"
    )
