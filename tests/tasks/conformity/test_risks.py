"""Probabilities of conformity and risks against published figures and independent arithmetic."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy import stats

from schemas.tolerance import ProductionPrior
from tasks.conformity.rules import (
    global_risks,
    probability_of_conformity,
    probability_of_nonconformity,
)

REAL = st.floats(-10, 10)
SMALL = st.floats(0.01, 10)


@pytest.mark.parametrize(
    ("value", "u", "limits", "published"),
    [
        # JCGM 106, 7.3: breakdown voltage of a Zener diode, burst strength of a container;
        # 7.4: kinematic viscosity of a motor oil.
        (-5.47, 0.05, (-math.inf, -5.40), 0.92),
        (509.7, 8.6, (490.0, math.inf), 0.99),
        (13.6, 1.8, (12.5, 16.3), 0.66),
    ],
)
def test_worked_examples_of_jcgm_106_are_met(
    value: float, u: float, limits: tuple[float, float], published: float
) -> None:
    assert round(probability_of_conformity(value, u, limits), 2) == published


@pytest.mark.parametrize(
    ("z", "published"), [(0.84, 0.80), (1.28, 0.90), (1.64, 0.95), (2.33, 0.99), (3.09, 0.999)]
)
def test_table_1_of_jcgm_106_is_met(z: float, published: float) -> None:
    """One limit at z standard uncertainties from the value, on either side."""
    for limits in ((-z, math.inf), (-math.inf, z)):
        conforms = probability_of_conformity(0.0, 1.0, limits)
        assert conforms == pytest.approx(published, abs=0.001)
        assert probability_of_nonconformity(0.0, 1.0, limits) == pytest.approx(1 - conforms)


@pytest.mark.parametrize(
    ("r", "published"), [(0.0, 0.50), (0.83, 0.05), (1.0, 0.025), (1.5, 0.0016), (3.0, 1e-6)]
)
def test_largest_risk_of_a_guard_band_is_that_of_ilac_g8(r: float, published: float) -> None:
    """ILAC-G8:09/2019, Table 1: a value on its acceptance limit, w = r·U with U = 2u."""
    assert probability_of_nonconformity(-2 * r, 1.0, (-math.inf, 0.0)) <= published
    assert probability_of_nonconformity(-2 * r, 1.0, (-math.inf, 0.0)) > 0.9e-3 * published


@pytest.mark.parametrize(
    ("sd", "u", "accepted", "consumer", "producer"),
    [
        # Deaver, How to maintain your confidence (1993): limits of 2 sd, ratio 4 and 2, the
        # second with an acceptance limit of 0.91 of the limit.
        (1.0, 0.25, 2.0, 0.008, 0.015),
        (1.0, 0.5, 1.82, 0.008, 0.066),
    ],
)
def test_published_global_risks_are_met(
    sd: float, u: float, accepted: float, consumer: float, producer: float
) -> None:
    risks = global_risks(ProductionPrior(mean=0.0, sd=sd), u, (-2.0, 2.0), (-accepted, accepted))
    assert risks.consumer == pytest.approx(consumer, abs=0.0006)
    assert risks.producer == pytest.approx(producer, abs=0.0006)


@pytest.mark.parametrize("dof", [math.inf, 3.0, 17.5])
def test_a_probability_is_the_integral_of_the_density(dof: float) -> None:
    density = stats.norm(1.3, 0.4) if math.isinf(dof) else stats.t(dof, 1.3, 0.4)
    grid = np.linspace(0.9, 2.2, 20_001)
    plain = np.trapezoid(density.pdf(grid), grid)
    assert probability_of_conformity(1.3, 0.4, (0.9, 2.2), dof) == pytest.approx(plain, abs=1e-8)


@pytest.mark.parametrize("limits", [(-0.5, 1.2), (-math.inf, 0.7), (0.2, math.inf)])
def test_global_risks_are_those_of_the_bivariate_normal(limits: tuple[float, float]) -> None:
    prior, u, shift = ProductionPrior(mean=0.3, sd=0.6), 0.2, 0.15
    accepted = limits[0] + shift, limits[1] - shift
    risks = global_risks(prior, u, limits, accepted)
    joint = stats.multivariate_normal(
        [0.3, 0.3], [[0.6**2, 0.6**2], [0.6**2, 0.6**2 + u**2]], seed=1
    )

    def box(part: tuple[float, float]) -> float:
        corners = ((part[1], accepted[1], 1), (part[0], accepted[1], -1),
                   (part[1], accepted[0], -1), (part[0], accepted[0], 1))  # fmt: skip
        return float(sum(sign * joint.cdf([x, y]) for x, y, sign in corners))

    inside, accepted_in_all = box(limits), box((-math.inf, math.inf))
    conform = stats.norm(0.3, 0.6).cdf(limits[1]) - stats.norm(0.3, 0.6).cdf(limits[0])
    assert risks.consumer == pytest.approx(accepted_in_all - inside, abs=1e-5)
    assert risks.producer == pytest.approx(conform - inside, abs=1e-5)


def test_a_small_risk_does_not_drown_in_rounding() -> None:
    risk = probability_of_nonconformity(0.0, 1.0, (-math.inf, 12.0))
    assert risk == pytest.approx(1.776e-33, rel=1e-3)
    assert probability_of_conformity(0.0, 1.0, (12.0, math.inf)) == pytest.approx(risk)


def test_a_measurement_far_finer_than_the_production_makes_no_wrong_decision() -> None:
    risks = global_risks(ProductionPrior(mean=0.0, sd=1.0), 1e-5, (-2.0, 2.0), (-2.0, 2.0))
    assert risks.consumer < 1e-5
    assert risks.producer < 1e-5


@given(REAL, SMALL, REAL, SMALL, st.floats(1, 50) | st.just(math.inf))
def test_both_probabilities_add_up_to_one(
    value: float, u: float, lower: float, width: float, dof: float
) -> None:
    about = (value, u, (lower, lower + width), dof)
    total = probability_of_conformity(*about) + probability_of_nonconformity(*about)
    assert total == pytest.approx(1.0, abs=1e-12)


@given(REAL, REAL, SMALL, REAL)
def test_moving_away_from_the_only_limit_is_never_less_likely_to_conform(
    value: float, further: float, u: float, upper: float
) -> None:
    assume(further < value)
    limits = (-math.inf, upper)
    assert probability_of_conformity(further, u, limits) >= probability_of_conformity(
        value, u, limits
    )


@given(REAL, SMALL, SMALL, SMALL, SMALL)
def test_wider_limits_are_never_less_likely_to_be_met(
    value: float, u: float, half: float, more: float, dof: float
) -> None:
    narrow = probability_of_conformity(value, u, (-half, half), dof)
    assert probability_of_conformity(value, u, (-half - more, half), dof) >= narrow - 1e-15


@given(REAL, SMALL, SMALL)
def test_mirrored_values_are_equally_likely_to_conform(value: float, u: float, half: float) -> None:
    limits = (-half, half)
    assert probability_of_conformity(value, u, limits) == pytest.approx(
        probability_of_conformity(-value, u, limits), abs=1e-15
    )
