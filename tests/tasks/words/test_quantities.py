"""Quantities are printed so that a person can read them, whatever their size."""

import numpy as np
import pytest

from tasks.words.quantities import (
    moment,
    multiple,
    percent,
    plain,
    probability,
    quantities,
    quantity,
    rough_quantity,
)


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
def test_numbers_of_every_size_are_readable(value, U, unit, shown) -> None:
    assert quantity(value, U, unit) == shown


def test_values_with_one_uncertainty_share_unit_and_places() -> None:
    made = quantities([0.0121, 0.0001], 0.0003, "m/s2")
    assert (made.values, made.uncertainties) == (("12.10", "0.10"), ("0.30", "0.30"))
    assert made.unit == "mm/s²"
    assert made.text(1) == "(0.10 ± 0.30) mm/s²"


def test_a_value_without_an_uncertainty_has_three_digits_in_a_unit_of_its_size() -> None:
    assert rough_quantity(0.01134, "s") == "11.3 ms"
    assert rough_quantity(-0.97, "1") == "−0.97"
    assert rough_quantity(np.radians(0.0527), "rad/s") == "0.0527 °/s"


def test_an_instant_of_a_long_run_is_a_whole_second() -> None:
    assert [moment(t) for t in (12.34, 1300.93, 1.6e9 + 0.4)] == ["12.3", "1301", "1600000000"]


def test_what_has_no_value_is_not_printed() -> None:
    made = quantities([None, None], None, "1")
    assert made.values == (None, None)
    assert made.unit == ""


def test_shares_probabilities_and_multiples_are_short() -> None:
    assert [percent(share) for share in (0.62, 0.001, 0.0)] == ["62 %", "< 1 %", "0 %"]
    assert [probability(p) for p in (0.0, 0.41)] == ["p < 10⁻¹²", "p = 0.41"]
    assert [multiple(ratio) for ratio in (-40.0, 551.2, 2e7)] == ["−40.0", "+551", "+2×10⁷"]
    assert [plain(number) for number in (149576.2, -3.2, 1e7)] == ["149576", "−3.2", "1×10⁷"]
