"""Advice on the recalibration interval, by the reliability method on a unit's own history.

The reliability method of NCSLI RP-1 and of ILAC-G24/OIML D 10: the probability that a unit is
still within its limits after a time t is R(t) = exp(−λt), and the interval is that at whose end R
is the target, t* = −ln R*/λ. A calibration finds whether the unit is within its limits, not since
when it is not: each interval gives exp(−λt) or 1 − exp(−λt). What is known of λ is that likelihood
over a flat prior on λ ≥ 0; without a failure its 95 % quantile is 3.0/Σt, the classical bound.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

TARGET = 0.95  # of the units within their limits at the end of an interval
LEAST_INTERVALS = 3
POINTS = 200_001
TAIL = 60.0  # λ·Σt of the conforming intervals up to which the likelihood is worked out

Advice = Literal["too few", "keep", "shorten", "may be longer"]


@dataclass(frozen=True)
class Interval:
    """Days between two calibrations, and whether the second found the unit within its limits."""

    days: float
    conforming: bool


@dataclass(frozen=True)
class IntervalAdvice:
    """What the history says of an interval.

    days: t* at the median of λ; shortest, longest: at its 95 % and 5 % quantiles, so that t* lies
    between them with 90 % probability. None where the history does not say.
    """

    advice: Advice
    intervals: int
    conforming: int
    days: float | None = None
    shortest: float | None = None
    longest: float | None = None


def advise(history: Sequence[Interval], agreed_days: float) -> IntervalAdvice:
    """Advice on an agreed interval; it is changed only where the history contradicts it.

    Shorten: longer than the longest t* that the history allows. May be longer: shorter than the
    shortest. With fewer than three intervals, or none that conforms, no t* is given; none that
    conforms of three or more is reason enough to shorten.
    """
    conforming = sum(interval.conforming for interval in history)
    counts = {"intervals": len(history), "conforming": conforming}
    if len(history) < LEAST_INTERVALS:
        return IntervalAdvice("too few", **counts)
    if conforming == 0:
        return IntervalAdvice("shorten", **counts)
    low, middle, high = failure_rates(history, (0.05, 0.5, 0.95))
    shortest, days, longest = (-math.log(TARGET) / rate for rate in (high, middle, low))
    advice: Advice = "keep"
    if agreed_days > longest:
        advice = "shorten"
    elif agreed_days < shortest:
        advice = "may be longer"
    return IntervalAdvice(advice, **counts, days=days, shortest=shortest, longest=longest)


def failure_rates(
    history: Sequence[Interval], probabilities: tuple[float, ...]
) -> tuple[float, ...]:
    """Quantiles of λ (per day); at least one interval of the history conforms."""
    days = np.array([interval.days for interval in history], float)
    good = np.array([interval.conforming for interval in history], bool)
    rates = np.linspace(0.0, TAIL / days[good].sum(), POINTS)[1:]
    log = -rates * days[good].sum()
    for t in days[~good]:
        log = log + np.log(-np.expm1(-rates * t))
    density = np.exp(log - log.max())
    share = np.cumsum(density) / density.sum()
    return tuple(float(np.interp(p, share, rates)) for p in probabilities)
