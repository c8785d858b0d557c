"""Which cases a trial has: drawn from its seed, nothing chosen by hand."""

from collections.abc import Iterator
from typing import Any, Literal

import numpy as np

from tests.proof.plant.case import Case, Data, EffectCall
from tests.proof.plant.effects import CATALOGUE, OUTSIDE

Kind = Literal["clean", "single", "faint", "several", "outside"]

ABSORBED = "gravity_value"  # the accelerometers' scale factors take it whole: it cannot be told
OF_ITS_OWN = ("earth_rotation", ABSORBED)  # sizes that no strength may change
SIZED = tuple(name for name in CATALOGUE if name not in OF_ITS_OWN)
TYPICAL = 1.0  # g differs by 0.5 to 2 mm/s² then
STRENGTHS = (10.0, 30.0, 100.0)  # z asked of an effect alone
OUTSIDE_STRENGTHS = (30.0, 100.0)
FAINT = 5.0  # z at which the limit of any detector is near 1 but not yet there
TOGETHER = 40.0  # z of each effect of several
NEEDS_THERMOMETER = ("temperature_bias", "temperature_scale", "thermal_gradient")

# how often each procedure is drawn; `partial` is three_axis with few rates
PROCEDURES = {
    "three_axis": 0.47, "single_axis": 0.15, "six_orientations": 0.12, "one_axis": 0.08,
    "rests": 0.05, "partial": 0.08, "ahrs": 0.05,
}  # fmt: skip
RATES = ((10.0, 50.0, 100.0, 200.0, 300.0), (20.0, 60.0, 150.0, 250.0), (50.0, 100.0, 300.0, 400.0))
FEW_RATES = ((50.0, 200.0), (30.0, 120.0), (300.0,))
DWELLS = (12.0, 16.0, 20.0, 30.0)  # s
MOST_ROWS = 110_000  # so that a case is explained within 8 s
# dwells: fixed ones, and for each rate
SEGMENTS = {"three_axis": (18, 6), "single_axis": (18, 6), "six_orientations": (12, 12),
        "one_axis": (2, 2), "rests": (12, 0), "ahrs": (22, 6)}  # fmt: skip
TURNING = {"ahrs": 300.0}  # s that no dwell makes shorter: ten turns, three axes, both ways
CLEAN = 120  # recordings without effects: as many as false alarms of 1 % ask for at the least


class Drawn(Data):
    """A case as drawn. z: asked of each effect; None: its size is what it is."""

    number: int
    kind: Kind
    case: Case
    z: float | None = None

    @property
    def label(self) -> str:
        """“0007”, the name of its folders: it tells nothing."""
        return f"{self.number:04d}"


Ask = tuple[Kind, tuple[str, ...], float | None]


def draw(seed: int, short: bool = False) -> list[Drawn]:
    """The cases of a trial, in an order that tells nothing. At least a fifth of them is clean."""
    rng = np.random.default_rng([seed, 5])
    asked = list(_short(rng) if short else _full(rng))
    asked += [("clean", (), None)] * (-(-len(asked) // 4) if short else CLEAN)
    order = rng.permutation(len(asked))
    return [
        Drawn(number=n, kind=asked[i][0], case=conditions(rng, asked[i]), z=asked[i][2])
        for n, i in enumerate(order, start=1)
    ]


def _full(rng: np.random.Generator) -> Iterator[Ask]:
    for name in SIZED:
        for z in STRENGTHS:
            for _ in range(2):
                yield "single", (name,), z
        yield "faint", (name,), FAINT
    for name in ("earth_rotation",) * 6 + (ABSORBED,) * 4:
        yield "single", (name,), None
    for name in OUTSIDE:
        yield from (("outside", (name,), z) for z in OUTSIDE_STRENGTHS)
    yield from (_several(rng, 2) for _ in range(24))
    yield from (_several(rng, 3) for _ in range(12))


def _short(rng: np.random.Generator) -> Iterator[Ask]:
    """A few of each kind, spread over the catalogue."""
    for k, name in enumerate(rng.choice(SIZED, 14, replace=False)):
        yield "single", (str(name),), STRENGTHS[k % 3]
    yield "faint", (str(rng.choice(SIZED)),), FAINT
    yield "single", ("earth_rotation",), None
    yield "single", (ABSORBED,), None
    for k, name in enumerate(rng.choice(OUTSIDE, 4, replace=False)):
        yield "outside", (str(name),), OUTSIDE_STRENGTHS[k % 2]
    yield from (_several(rng, 2) for _ in range(2))
    yield _several(rng, 3)


def _several(rng: np.random.Generator, count: int) -> Ask:
    together = [name for name in CATALOGUE if name != ABSORBED]
    return "several", tuple(map(str, rng.choice(together, count, replace=False))), TOGETHER


def conditions(rng: np.random.Generator, ask: Ask, procedure: str | None = None) -> Case:
    """A case with these effects at typical size, its unit, station and procedure drawn."""
    kind, effects, _ = ask
    names = list(PROCEDURES)
    drawn = procedure or str(rng.choice(names, p=list(PROCEDURES.values())))
    if kind == "outside" and drawn == "ahrs":  # nothing there moves to a position, as some need
        drawn = "three_axis"
    declared: dict[str, Any] = {
        "seed": int(rng.integers(1, 1_000_000)),
        "grade": str(rng.choice(["consumer", "industrial", "tactical"])),
        "procedure": "three_axis" if drawn == "partial" else drawn,
        "rate_hz": int(rng.choice([100, 50, 200], p=[0.7, 0.15, 0.15])),
        "order": str(rng.choice(["rising", "alternating", "shuffled"])),
        "climate": str(rng.choice(["room", "cycling"], p=[0.7, 0.3])),
        "latitude_deg": round(float(rng.uniform(-50.0, 60.0)), 2),
        "heading_deg": float(rng.choice([0.0, round(rng.uniform(-180.0, 180.0), 1)])),
        "gravity_m_s2": round(float(rng.uniform(9.781, 9.825)), 4),
        "effects": tuple(EffectCall(name=name, strength=TYPICAL) for name in effects),
    }
    if drawn == "ahrs":  # its turns alone would fill a run at the highest rate
        declared["rate_hz"] = min(declared["rate_hz"], 100)
    few = drawn == "partial" or declared["rate_hz"] == 200
    choices = FEW_RATES if few else RATES
    declared["rates_deg_s"] = choices[int(rng.integers(len(choices)))]
    declared["dwell_s"] = _dwell(float(rng.choice(DWELLS)), declared)
    # What no thermometer recorded cannot be named after it; a warm-up can.
    unrecorded = 0.5 if "thermal_transient" in effects else 0.15
    needed = any(name in NEEDS_THERMOMETER for name in effects)
    declared["temperature_recorded"] = needed or bool(rng.uniform() > unrecorded)
    # Where the site is not told, level directions are the table's: no name of the catalogue
    # loses its parameters for that in a trial that compares them.
    declared["site_known"] = kind not in ("clean", "outside") or bool(rng.uniform() > 0.15)
    return Case(**declared)


def _dwell(drawn: float, declared: dict[str, Any]) -> float:
    """The longest dwell up to the one drawn that keeps the run short enough."""
    fixed, for_each = SEGMENTS[declared["procedure"]]
    segments = fixed + for_each * len(declared["rates_deg_s"])
    seconds = MOST_ROWS / declared["rate_hz"] - TURNING.get(declared["procedure"], 0.0)
    longest = seconds / segments - 4.0
    return max(min(drawn, float(np.floor(longest))), min(DWELLS))
