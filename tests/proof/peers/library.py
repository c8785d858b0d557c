"""The generic library: powers and products of what was commanded and recorded beside the unit.

Column names are formulas: factors parted by “·”, squares “²”, cubes “³”. ω: rate, u: the upward
vertical, n: North (unit vectors in the body), α: angular acceleration, T and Ṫ: the unit's
temperature and its rate (the room's where the unit gives none), V: supply, t: time.
"""

from collections.abc import Iterator, Mapping
from itertools import combinations_with_replacement

import numpy as np

from tasks.motion.whole import Motion

AXES = "xyz"
RECORDED = {"supply_voltage": "V", "humidity": "H", "pressure": "p", "vibration": "vibration"}
SQUARED = ("ω", "u")
WARM_UPS = (60.0, 300.0, 900.0)  # s
LEAST = 1e-9  # spread of a course that says something

Library = Mapping[str, np.ndarray]


def library(motion: Motion) -> dict[str, np.ndarray]:
    """(n,) each: all that a stepwise regression may choose from."""
    columns = polynomial(motion)
    rate = motion.rate
    columns |= {f"|ω_{a}|": np.abs(rate[:, i]) for i, a in enumerate(AXES)}
    columns |= {f"exp(-t/{tau:g})": np.exp(-motion.t / tau) for tau in WARM_UPS}
    return {name: _bridged(series) for name, series in columns.items()}


def polynomial(motion: Motion) -> dict[str, np.ndarray]:
    """The same without what is no polynomial of the inputs: of second degree in rates, vertical,
    temperature, time and supply; cubes of rates and vertical; the rest as it is."""
    inputs = _inputs(motion)
    crossed = {k: v for k, v in inputs.items() if k[0] in "ωuTtV"}
    columns = dict(inputs)
    for a, b in combinations_with_replacement(crossed, 2):
        columns[f"{a}²" if a == b else f"{a}·{b}"] = crossed[a] * crossed[b]
    for name, series in inputs.items():
        if name[0] in SQUARED:
            columns[f"{name}³"] = series**3
    return {name: _bridged(series) for name, series in columns.items()}


def _inputs(motion: Motion) -> dict[str, np.ndarray]:
    return {
        name: series
        for name, series in _every(motion)
        if np.isfinite(series).any() and np.nanstd(series) > LEAST
    }


def _every(motion: Motion) -> Iterator[tuple[str, np.ndarray]]:
    for letter, series in (("ω", motion.rate), ("u", motion.up)):
        yield from ((f"{letter}_{a}", series[:, i]) for i, a in enumerate(AXES))
    recorded = motion.recorded
    own = "temperature" in recorded
    temperature = recorded.get("temperature", recorded.get("air_temperature"))
    if temperature is not None:
        yield "T", _centred(temperature)
    if own:
        yield "Ṫ", recorded["temperature_rate"]
    yield "t", _centred(motion.t)
    for name, symbol in RECORDED.items():
        if name in recorded:
            yield symbol, _centred(recorded[name])
    for letter, series in (("n", motion.north), ("α", motion.acceleration)):
        yield from ((f"{letter}_{a}", series[:, i]) for i, a in enumerate(AXES))


def _centred(series: np.ndarray) -> np.ndarray:
    return np.asarray(series - series[np.isfinite(series)].mean())


def _bridged(series: np.ndarray) -> np.ndarray:
    """Nothing where the motion is not known: those blocks have no weight."""
    return np.nan_to_num(series)
