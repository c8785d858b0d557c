"""Vibration level of the unit, from the noise of its accelerometers."""

import numpy as np

AT_REST = 1e-3  # rad/s
STEADY = 0.02  # of the speed: a segment that scatters more is a ramp
EFFECTIVE_ROWS = 1.3  # samples of three axes: what their second differences are worth for each row
MIN_SPEEDS = 2  # that determine a power of the speed
EXPONENTS = np.round(np.arange(0.5, 6.01, 0.1), 1)  # of the vibration's power by the speed
WHOLE_BONUS = 4.0  # chi-squared
MAX_CHI2 = 3.0  # per segment


def vibration(variance: np.ndarray, segment: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """(n,) mean square of the accelerometers' noise beyond that at rest, by the speed it has.

    variance: (segments + 1, 2); segment: (n,) index of each row; speed: (n,) rad/s. A power of
    the speed where one describes it, which has less noise than single segments; else between them.
    """
    known = [k for k in range(len(variance) - 1) if np.isfinite(variance[k, 1])]
    if not known:
        return np.zeros(len(segment))
    speeds = np.array([float(np.median(speed[segment == k])) for k in known])
    resting = speeds < AT_REST
    at_rest = float(np.median(variance[known, 1][resting if resting.any() else slice(None)]))
    steady = np.array([float(np.std(speed[segment == k])) for k in known]) < STEADY * speeds
    turning = ~resting & steady if (~resting & steady).any() else ~resting
    beyond = (variance[known, 1] - at_rest)[turning]
    rows = np.array([np.count_nonzero(segment == k) for k in known])[turning]
    u = variance[known, 1][turning] * np.sqrt(2.0 / (EFFECTIVE_ROWS * np.maximum(rows, 1)))
    law = _power_law(speeds[turning], beyond, u)
    if law is not None:
        return law[0] * speed ** law[1]
    order = np.argsort(speeds[turning])
    at, level = speeds[turning][order], np.maximum(beyond[order], 0.0)
    return np.interp(speed, np.append(0.0, at), np.append(0.0, level))


def _power_law(speeds: np.ndarray, beyond: np.ndarray, u: np.ndarray) -> tuple[float, float] | None:
    """Factor and exponent of c·speed^n; a whole n where it does as well. None: it is no power."""
    if len(np.unique(np.round(speeds, 2))) < MIN_SPEEDS:
        return None
    powers = speeds[:, None] ** EXPONENTS / u[:, None]
    factors = (powers * (beyond / u)[:, None]).sum(axis=0) / (powers**2).sum(axis=0)
    cost = ((beyond / u)[:, None] - factors * powers) ** 2
    cost = np.where(factors > 0, cost.sum(axis=0), np.inf)
    whole = np.isclose(EXPONENTS, np.round(EXPONENTS))
    best = int(np.argmin(cost + WHOLE_BONUS * ~whole))
    if not cost[best] < MAX_CHI2 * len(speeds):
        return None
    return float(factors[best]), float(EXPONENTS[best])
