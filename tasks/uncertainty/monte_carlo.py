"""Propagation of distributions by Monte Carlo: JCGM 101:2008 (JJF 1059.2-2012)."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal

import numpy as np

from schemas.base import Unusable
from schemas.calibration import Budget
from tasks.uncertainty.budget import Contribution, InputQuantity, combine
from tasks.uncertainty.propagation import TWO_SIGMA, checked_correlation
from tasks.uncertainty.type_a import draw
from tasks.words import message

MIN_BLOCK = 10_000  # JCGM 101, 7.9.4 b)
HEAVY_TAIL = 4.0  # degrees of freedom up to which a sample's deviation does not settle
MAX_TRIALS = 20_000_000  # 160 MB of results


@dataclass(frozen=True)
class Interval:
    """A coverage interval and its coverage probability."""

    low: float
    high: float
    probability: float


@dataclass(frozen=True)
class MonteCarlo:
    """Estimate, standard uncertainty and coverage intervals from `trials` model values.

    symmetric: probabilistically symmetric interval; shortest: the shortest one. tolerance: δ
    that estimate, u and the symmetric interval's ends have reached.
    """

    value: float
    u: float
    symmetric: Interval
    shortest: Interval
    trials: int
    tolerance: float


def numerical_tolerance(u: float, digits: int) -> float:
    """δ = ½·10ˡ where u = c·10ˡ and c has `digits` figures (7.9.2); 0 for u = 0."""
    if u <= 0.0:
        return 0.0
    exponent = int(f"{u:.{digits - 1}e}".partition("e")[2])
    return 0.5 * 10.0 ** (exponent - digits + 1)


def monte_carlo(
    function: Callable[..., np.ndarray],
    quantities: Sequence[InputQuantity],
    correlation: np.ndarray | None = None,
    *,
    seed: int,
    digits: int = 2,
    probability: float = TWO_SIGMA,
) -> MonteCarlo:
    """Monte Carlo in blocks until twice the standard deviation of each result is below δ (7.9.4).

    function: takes n arrays (M,) and returns (M,) model values. digits: figures of u that are to
    be reliable (1 or 2). The same seed gives the same result bit for bit. Without a standard
    deviation that could settle (`has_deviation`) u is NaN, and the interval's ends alone settle.
    Raises Unusable where correlated inputs are not normal (6.4.8), where the model gives numbers
    that are not finite, or where 20 million trials are not enough.
    """
    draws = _sampler(quantities, correlation, np.random.default_rng(seed))
    block = max(math.ceil(100.0 / (1.0 - probability)), MIN_BLOCK)
    blocks: list[np.ndarray] = []
    figures: list[tuple[float, float, float, float]] = []
    has_u = has_deviation(quantities)
    for values in _evaluations(function, draws, block):
        blocks.append(values)
        ends = symmetric_interval(np.sort(values), probability)
        figures.append((values.mean(), values.std(ddof=1), ends.low, ends.high))
        if len(blocks) < 2:
            continue
        low, high = np.mean(figures, axis=0)[2:]
        u = _pooled_u(figures, block) if has_u else (high - low) / 4.0
        tolerance = numerical_tolerance(u, digits)
        spread = np.std(figures, axis=0, ddof=1) / math.sqrt(len(figures))
        if np.all(2.0 * spread[0 if has_u else 2 :] <= tolerance):
            ordered = np.sort(np.concatenate(blocks))
            return MonteCarlo(
                value=float(ordered.mean()),
                u=float(ordered.std(ddof=1)) if has_u else math.nan,
                symmetric=symmetric_interval(ordered, probability),
                shortest=shortest_interval(ordered, probability),
                trials=len(ordered),
                tolerance=tolerance,
            )
    raise Unusable(
        f"Monte Carlo did not settle to {digits} digits within {MAX_TRIALS} trials; ask for fewer "
        "digits"
    )


def has_deviation(quantities: Sequence[InputQuantity]) -> bool:
    """Whether the draws' standard deviation converges: not for `t` of 4 dof or fewer.

    With two or fewer there is none at all (6.4.9.4); up to four its own variance is infinite.
    """
    return all(q.distribution != "t" or q.dof > HEAVY_TAIL for q in quantities)


def symmetric_interval(ordered: np.ndarray, probability: float) -> Interval:
    """The probabilistically symmetric interval of sorted model values (7.7.2)."""
    count = _inside(len(ordered), probability)
    first = (len(ordered) - count + 1) // 2
    return Interval(float(ordered[first - 1]), float(ordered[first - 1 + count]), probability)


def shortest_interval(ordered: np.ndarray, probability: float) -> Interval:
    """The shortest interval of sorted model values (7.7.4)."""
    count = _inside(len(ordered), probability)
    first = int(np.argmin(ordered[count:] - ordered[:-count]))
    return Interval(float(ordered[first]), float(ordered[first + count]), probability)


def with_monte_carlo(budget: Budget, result: MonteCarlo) -> Budget:
    """The budget with u and interval from Monte Carlo; value and lines stay the linear ones.

    The value is that of the item's equation at the estimates. The interval is the
    probabilistically symmetric one, U half its length, k = U/u. Where the draws have no standard
    deviation, u stays that of the law of propagation.
    """
    interval = result.symmetric
    U = (interval.high - interval.low) / 2.0
    u = budget.u_c if math.isnan(result.u) else result.u
    return budget.model_copy(
        update={
            "u_c": u,
            "U": U,
            "k": U / u if u > 0.0 else 0.0,
            "coverage_probability": interval.probability,
            "coverage_interval": (interval.low, interval.high),
            "evaluation": "Monte Carlo",
        }
    )


def _evaluations(
    function: Callable[..., np.ndarray], draws: Callable[[int], np.ndarray], block: int
) -> Iterator[np.ndarray]:
    for _ in range(MAX_TRIALS // block):
        values = np.broadcast_to(np.asarray(function(*draws(block)), float), (block,))
        if not np.isfinite(values).all():
            raise Unusable(
                "the model gives values that are not finite for some drawn inputs; their "
                "distributions reach where the model is not defined"
            )
        yield values


def _pooled_u(figures: Sequence[tuple[float, float, float, float]], block: int) -> float:
    """Standard deviation of all values from the means and deviations of equal blocks."""
    means, deviations = np.array(figures)[:, 0], np.array(figures)[:, 1]
    squares = (block - 1) * (deviations**2).sum() + block * ((means - means.mean()) ** 2).sum()
    return float(math.sqrt(squares / (block * len(figures) - 1)))


def _inside(count: int, probability: float) -> int:
    """q of 7.7: pM, or the integer part of pM + ½."""
    return int(probability * count + 0.5)


def _sampler(
    quantities: Sequence[InputQuantity], correlation: np.ndarray | None, rng: np.random.Generator
) -> Callable[[int], np.ndarray]:
    """A function that draws (n, M) values of the inputs, correlated ones jointly (6.4)."""
    r = checked_correlation(correlation, len(quantities))
    joint = [i for i, row in enumerate(r != np.eye(len(r))) if row.any()]
    for i in joint:
        if quantities[i].distribution != "normal":
            raise Unusable(
                f"{quantities[i].symbol} is correlated and {quantities[i].distribution}; only "
                "normal inputs can be drawn jointly"
            )
    values, vectors = np.linalg.eigh(r[np.ix_(joint, joint)])
    root = vectors * np.sqrt(np.maximum(values, 0.0))

    def draws(trials: int) -> np.ndarray:
        x = np.array([draw(q.distribution, trials, rng, q.dof) for q in quantities])
        x[joint] = root @ x[joint]
        estimates, u = np.array([(q.estimate, q.u) for q in quantities]).T
        return estimates[:, None] + u[:, None] * x

    return draws


# “As the specification's example”: Appendix A of JJF 2003-2022 and of JJF 1536-2015.
#
# Both appendices write down the law of propagation and then do something else: three components,
# u₁ of the table, u₂ of the data acquisition, u₃ of the repeatability, added in quadrature with
# sensitivity 1 whatever their units, where u₃ is the plain sum of the positions' uncertainties.
#
# One chain of roundings gives every printed number: u_c is rounded half-even to three significant
# digits, U = 2·u_c is taken from that, and rounded up to two digits (2.20165e-4 → 2.20e-4 →
# 4.40e-4 → 4.4e-4; without the first step 4.4033e-4 would be 4.5e-4). JJF 2003, A.2.4 alone
# prints U before the last step (5.36e-4).

TABLE = 1.0e-4  # u₁: U = 2e-4 with k = 2
EXAMPLE = "Appendix A"  # who states that
BITS = 12  # N of the examples; a unit under test has its own
TABLE_NAME = message("uncertainty-example-table")
ACQUISITION_NAME = message("uncertainty-example-acquisition")
REPEATABILITY_NAME = message("uncertainty-example-repeatability")
K = 2.0
DIGITS_OF_U_C = 3


def acquisition(bits: float) -> float:
    """u₂ = 2⁻ᴺ/√3 for N effective bits, eq. (A.3): the whole step taken as half-width."""
    return 2.0**-bits / math.sqrt(3.0)


def combine_as_example(
    result: str,
    unit: str,
    value: float,
    repeatability: Sequence[float],
    table: float = TABLE,
    bits: float = BITS,
    source: str = EXAMPLE,
) -> Budget:
    """A budget as the appendices do it: u_c = √(u₁² + u₂² + u₃²), U = 2·u_c.

    repeatability: standard uncertainties that are added up to u₃. source: who states `table`.
    u_c carries three significant digits, so that a certificate prints the appendix's U (rounded up
    to two digits).
    """
    u3 = math.fsum(repeatability)
    quantities = (
        InputQuantity("u1", TABLE_NAME, unit, table, "B", "normal", source=source),
        InputQuantity("u2", ACQUISITION_NAME, unit, acquisition(bits), "B", "rectangular"),
        InputQuantity("u3", REPEATABILITY_NAME, unit, u3, "A", "normal"),
    )
    exact = combine(result, unit, value, [Contribution(quantity, 1.0) for quantity in quantities])
    u_c = float(f"{exact.u_c:.{DIGITS_OF_U_C - 1}e}")
    # The decimal product: 2 × 2.2e-4 must not be a hair above 4.4e-4.
    return exact.model_copy(
        update={
            "u_c": u_c,
            "k": K,
            "U": float(Decimal(repr(u_c)) * Decimal(K)),
            "coverage_probability": TWO_SIGMA,
            "half_width_95": None,
            "evaluation": "as the specification's example",
        }
    )
