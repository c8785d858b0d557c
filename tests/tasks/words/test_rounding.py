"""How a result and its uncertainty are written down (JJF 1059.1)."""

import math
from decimal import ROUND_HALF_EVEN, Context, Decimal

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tasks.words.rounding import column, round_like, round_up

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
def test_published_uncertainties_are_rounded_up_to_two_digits(
    uncertainty: float, printed: str
) -> None:
    assert round_up(uncertainty) == Decimal(printed)


@pytest.mark.parametrize("nonsense", [-1e-9, math.inf, math.nan])
def test_an_uncertainty_that_cannot_be_one_is_refused(nonsense: float) -> None:
    with pytest.raises(ValueError, match="finite number"):
        round_up(nonsense)


@given(uncertainties)
def test_rounded_uncertainty_has_two_digits_and_is_never_noticeably_smaller(U: float) -> None:
    rounded = round_up(U)
    assert len(rounded.as_tuple().digits) == 2
    assert float(rounded) >= U * (1 - HALF_OF_U_C)
    assert float(rounded) <= U * 1.1 * (1 + HALF_OF_U_C)


@given(uncertainties, st.floats(1.5, 13.0))
def test_only_the_rounding_of_the_combined_uncertainty_makes_a_printed_one_smaller(
    u_c: float, k: float
) -> None:
    assert float(round_up(k * u_c, k)) >= k * float(THREE_DIGITS.create_decimal(repr(u_c))) * (
        1 - 1e-9
    )


@given(uncertainties)
def test_rounding_a_rounded_uncertainty_changes_nothing(U: float) -> None:
    assert round_up(float(round_up(U))) == round_up(U)


@given(values, st.floats(1e-9, 1e3))
def test_value_moves_by_at_most_half_of_the_last_place(value: float, U: float) -> None:
    rounded = round_up(U)
    place = Decimal((0, (1,), rounded.as_tuple().exponent))
    assert abs(round_like(value, rounded) - Decimal(repr(value))) <= place / 2


def test_value_is_rounded_half_even() -> None:
    assert [str(round_like(v, Decimal("0.10"))) for v in (0.125, 0.135, -0.125)] == [
        "0.12",
        "0.14",
        "-0.12",
    ]


def test_a_value_that_rounds_to_zero_has_no_sign() -> None:
    assert column([-1e-9], [1e-3]).values == ("0.0000",)


def test_plain_decimals_where_they_are_readable() -> None:
    made = column([1.000234567, 0.99991, -1.0], [4.23e-4, 1.2e-5, 4.3e-4])
    assert made.exponent == 0
    assert made.values == ("1.00023", "0.999910", "−1.00000")
    assert made.uncertainties == ("0.00043", "0.000012", "0.00043")


def test_small_numbers_share_one_power_of_ten() -> None:
    made = column([3.124e-5, -1.2e-7], [1.24e-7, 1.31e-8])
    assert made.exponent == -6
    assert made.values == ("31.24", "−0.120")
    assert made.uncertainties == ("0.13", "0.014")


def test_large_uncertainties_show_no_digit_that_is_not_significant() -> None:
    made = column([1234567.0], [12345.0])
    assert (made.exponent, made.values, made.uncertainties) == (6, ("1.235",), ("0.013",))


def test_a_null_stays_null_beside_numbers() -> None:
    made = column([None, 0.5, math.nan], [None, 0.01, 0.01])
    assert made.values == (None, "0.500", None)
    assert made.uncertainties == (None, "0.010", "0.010")
    assert column([None], [None]).exponent == 0


def test_a_value_without_uncertainty_keeps_six_digits() -> None:
    assert column([0.123456789, 0.5], [None, 0.0]).values == ("0.123457", "0.5")


@given(st.lists(st.tuples(values, uncertainties), min_size=1, max_size=6))
def test_column_says_what_rounding_says(rows: list[tuple[float, float]]) -> None:
    assume(all(value == 0 or abs(value) > 1e-12 for value, _ in rows))
    made = column([v for v, _ in rows], [U for _, U in rows])
    for (value, U), shown, U_shown in zip(rows, made.values, made.uncertainties, strict=True):
        assert "e" not in f"{shown}{U_shown}".lower()
        assert number(shown, made.exponent) == round_like(value, round_up(U))
        assert number(U_shown, made.exponent) == round_up(U)
