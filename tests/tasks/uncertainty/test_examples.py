"""Appendix A of both specifications, digit for digit."""

from decimal import ROUND_CEILING, Decimal

import pytest

from tasks.uncertainty.monte_carlo import acquisition, combine_as_example
from tasks.words.numbers import round_up

SCALE, PAIR = (1.22e-4,), (2.51e-3,) * 2
PRINTED = {  # clause: what is added up to u3, u3, u_c, U
    "JJF 2003-2022, A.1": (SCALE, "1.22e-4", "2.12e-4", "4.3e-4"),
    "JJF 2003-2022, A.2": ((3.41e-5,) * 6, "2.046e-4", "2.68e-4", "5.36e-4"),
    "JJF 2003-2022, A.3": (PAIR, "5.02e-3", "5.02e-3", "1.1e-2"),
    "JJF 2003-2022, A.4": (SCALE, "1.22e-4", "2.12e-4", "4.3e-4"),
    "JJF 2003-2022, A.5": (PAIR, "5.02e-3", "5.02e-3", "1.1e-2"),
    "JJF 1536-2015, A.1": (SCALE, "1.22e-4", "2.12e-4", "4.3e-4"),
    "JJF 1536-2015, A.2": ((3.41e-5,) * 4, "1.36e-4", "2.20e-4", "4.4e-4"),
    "JJF 1536-2015, A.3": (PAIR, "5.02e-3", "5.02e-3", "1.1e-2"),
}


def to_digits_of(printed: str, value: float) -> Decimal:
    digits = len(Decimal(printed).as_tuple().digits)
    return Decimal(f"{value:.{digits - 1}e}")


@pytest.mark.parametrize("clause", PRINTED)
def test_every_printed_digit_of_the_worked_examples(clause):
    components, u3, u_c, U = PRINTED[clause]
    budget = combine_as_example("result", "1", 0.0, components)
    table, bits, repeatability = budget.inputs
    assert (table.u, f"{bits.u:.2e}") == (1.0e-4, "1.41e-04")
    assert to_digits_of(u3, repeatability.u) == Decimal(u3)
    assert Decimal(repr(budget.u_c)) == Decimal(u_c)
    three_digits = len(Decimal(U).as_tuple().digits) == 3
    # A.2 of JJF 2003 prints U as it is; all others print it rounded up to two digits.
    assert (Decimal(repr(budget.U)) if three_digits else round_up(budget.U)) == Decimal(U)


def test_without_three_digits_of_u_c_jjf1536_a2_would_not_come_out():
    exact = (1e-8 + acquisition(12) ** 2 + (4 * 3.41e-5) ** 2) ** 0.5
    assert Decimal(repr(2 * exact)).quantize(Decimal("1e-5"), ROUND_CEILING) == Decimal("4.5e-4")
    assert round_up(2 * exact) == Decimal("4.4e-4")


def test_the_examples_budget_says_what_it_is():
    budget = combine_as_example("gyro_bias", "deg/s", 0.1, (1e-3, 2e-3), table=5e-5, bits=16)
    assert budget.evaluation == "as the specification's example"
    assert budget.k == 2.0
    assert [line.u for line in budget.inputs] == [5e-5, acquisition(16), 3e-3]
    assert sum(line.share for line in budget.inputs) == pytest.approx(1.0)
