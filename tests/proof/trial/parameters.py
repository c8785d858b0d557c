"""The truth's parameters in the names, units and definitions that `explain` states.

One function for each effect whose definition differs; the rest is renamed. Left out:
bias_random_walk (a path, no parameters), vibration_rectification (the plant's power is that of
the vibration above the unit's band, the found one's what folds into the band) and what is no
measured number (an order, a number of turns, the axis of a table).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import chi2, ncx2

from tasks.explain.search.stepwise import FALSE_ALARMS
from tests.proof.plant.effects import EFFECTS

AXES = "xyz"
STANDARD_G = 9.80665  # m/s²
PER_HOUR = float(np.degrees(3600.0))  # deg/h in a rad/s
OFF_DIAGONAL = [(i, j) for i in range(3) for j in range(3) if i != j]
EVERY_PAIR = [(i, j) for i in range(3) for j in range(3)]

Known = dict[str, tuple[float, str]]  # name: true value, unit of it as stated


@dataclass(frozen=True)
class Truth:
    """What a sealed truth.json says. unit: Kg, Ka … of models (1) and (2)."""

    effects: Mapping[str, Mapping[str, Any]]
    unit: Mapping[str, Any]
    case: Mapping[str, Any]

    def scale(self, triad: str) -> np.ndarray:
        """(3,) scale factors. The plant's sensor effects act on what the element answers to,
        K·ω and Ka·f; those found act on the input."""
        return np.diag(np.array(self.unit[triad]))


def known_parameters(truth: Truth, effect: str) -> Known:
    """True values by the names that `explain` uses; empty where nothing can be compared."""
    convert = CONVERSIONS.get(effect)
    return {} if convert is None else convert(truth, truth.effects[effect])


def _vector(name: str, values: Any, unit: str) -> Known:
    return {f"{name}_{a}": (float(v), unit) for a, v in zip(AXES, values, strict=True)}


def _matrix(
    letter: str, values: Any, unit: str, pairs: list[tuple[int, int]] = EVERY_PAIR
) -> Known:
    rows = np.asarray(values, dtype=float)
    return {f"{letter}_{AXES[i]}{AXES[j]}": (float(rows[i, j]), unit) for i, j in pairs}


def _both(gyro: Any, accel: Any, per: str = "") -> Known:
    """Biases of both triads, per something."""
    units = (f"(rad/s)/{per}", f"(m/s2)/{per}") if per else ("rad/s", "m/s2")
    return _vector("gyro", gyro, units[0]) | _vector("accel", accel, units[1])


def _follows(per: str) -> Callable[[Truth, Mapping[str, Any]], Known]:
    return lambda truth, p: _both(p["gyro"], p["accel"], per)


def _same(name: str, unit: str, response: str | None = None) -> Callable[..., Known]:
    """One number that means the same; `said` where it has another name."""
    return lambda truth, p: {response or name: (float(p[name]), unit)}


def _earth(truth: Truth, p: Mapping[str, Any]) -> Known:
    latitude = np.radians(p["latitude_deg"])
    up, north = PER_HOUR * p["rate"] * np.sin(latitude), PER_HOUR * p["rate"] * np.cos(latitude)
    return {"vertical_rate": (float(up), "deg/h"), "north_rate": (float(north), "deg/h")}


def _tilt(truth: Truth, p: Mapping[str, Any]) -> Known:
    return {"east": (p["east"], "rad"), "north": (p["north"], "rad")}


def _nonorthogonality(truth: Truth, p: Mapping[str, Any]) -> Known:
    return {f"angle_{k}": (angle, "rad") for k, angle in enumerate(p["angles"], start=1)}


def _wobble(truth: Truth, p: Mapping[str, Any]) -> Known:
    """A·sin(mθ + φ) as sine and cosine; the plant's East and North turn with the heading."""
    heading = np.radians(truth.case["heading_deg"])
    sine, cosine = (p["amplitude"] * part(p["phases"]) for part in (np.cos, np.sin))
    found: Known = {}
    for part, (e, n) in (("sin", sine), ("cos", cosine)):
        found[f"east_{part}"] = (float(e * np.cos(heading) + n * np.sin(heading)), "rad")
        found[f"north_{part}"] = (float(n * np.cos(heading) - e * np.sin(heading)), "rad")
    return found


def _remount(truth: Truth, p: Mapping[str, Any]) -> Known:
    """Against the first fixing, which the cross couplings take."""
    vectors = np.array(p["vectors"])
    return {
        f"{a}_{number}": (float(vectors[number, i] - vectors[0, i]), "rad")
        for number in range(1, len(vectors)) for i, a in enumerate(AXES)
    }  # fmt: skip


def _ripple(truth: Truth, p: Mapping[str, Any]) -> Known:
    return _wave("depth", p["depth"], p["phase"], "1")


def _eccentricity(truth: Truth, p: Mapping[str, Any]) -> Known:
    return _wave("amplitude", p["amplitude"], p["phase"], "rad")


def _wave(name: str, size: float, phase: float, unit: str) -> Known:
    """size · sin(x + phase) as sine and cosine of x."""
    return {
        f"{name}_sin": (float(size * np.cos(phase)), unit),
        f"{name}_cos": (float(size * np.sin(phase)), unit),
    }


def _dropped(truth: Truth, p: Mapping[str, Any]) -> Known:
    """In the order of their times."""
    found: Known = {}
    for k, (time, lost) in enumerate(zip(p["times"], p["lost"], strict=True), start=1):
        found |= {f"time_{k}": (time, "s"), f"lost_{k}": (float(lost), "1")}
    return found


def _gyro_nonlinearity(truth: Truth, p: Mapping[str, Any]) -> Known:
    """Both count as a share at the run's top rate."""
    return _vector("coefficient", p["coefficient"] * truth.scale("Kg") ** p["order"], "1")


def _asymmetry(truth: Truth, p: Mapping[str, Any]) -> Known:
    return _vector("half_difference", p["half_difference"] * truth.scale("Kg"), "1")


def _scale_g(truth: Truth, p: Mapping[str, Any]) -> Known:
    return _matrix("S", np.array(p["S"]) * truth.scale("Kg")[:, None], "1/(m/s2)")


def _accel_nonlinearity(truth: Truth, p: Mapping[str, Any]) -> Known:
    """The plant counts in standard gravity, what is found in the station's."""
    order = p["order"]
    gravity = (truth.case["gravity_m_s2"] / STANDARD_G) ** (order - 1)
    return _vector("coefficient", p["coefficient"] * truth.scale("Ka") ** order * gravity, "1")


def _temperature_scale(truth: Truth, p: Mapping[str, Any]) -> Known:
    gyro, accel = p["gyro"] * truth.scale("Kg"), p["accel"] * truth.scale("Ka")
    return _vector("gyro", gyro, "1/K") | _vector("accel", accel, "1/K")


def _transient(truth: Truth, p: Mapping[str, Any]) -> Known:
    return _both(p["gyro"], p["accel"]) | {"time_constant": (p["tau"], "s")}


def _bandwidth(truth: Truth, p: Mapping[str, Any]) -> Known:
    return {"time_constant": (1.0 / (2.0 * np.pi * p["corner"]), "s")}


def _mains(truth: Truth, p: Mapping[str, Any]) -> Known:
    """Amplitudes are told without a sign; those of the third harmonic carry its number."""
    sizes = np.abs([*p["gyro"], *p["accel"]])
    first = _both(sizes[:3], sizes[3:])
    third = _both(p["third"] * sizes[:3], p["third"] * sizes[3:])
    return first | {f"{n}_3": v for n, v in third.items()} | {"frequency": (p["frequency"], "Hz")}


def _step(truth: Truth, p: Mapping[str, Any]) -> Known:
    return _both(p["gyro"], p["accel"]) | {"time": (p["time"], "s")}


def _frame(truth: Truth, p: Mapping[str, Any]) -> Known:
    """The plant turns the room's axes, what is found turns the vertical in them."""
    return {"tilt_east": (-p["tilt"][0], "rad"), "tilt_north": (-p["tilt"][1], "rad")}


def _jitter(truth: Truth, p: Mapping[str, Any]) -> Known:
    """Of the unit's stamps alone; what the table's add to it is not the same everywhere."""
    return {} if p.get("of_table") else {"jitter": (float(p["sigma"]), "s")}


CONVERSIONS: Mapping[str, Callable[[Truth, Mapping[str, Any]], Known]] = {
    "earth_rotation": _earth,
    "gravity_value": _same("difference", "m/s2"),
    "lever_arm": lambda truth, p: _vector("r", p["r"], "m"),
    "size_effect": lambda truth, p: _matrix("r", p["r"], "m"),
    "axis_tilt": _tilt,
    "axis_nonorthogonality": _nonorthogonality,
    "axis_wobble": _wobble,
    "structural_compliance": lambda truth, p: _matrix("C", p["C"], "rad/(rad/s)2", OFF_DIAGONAL),
    "remount_misalignment": _remount,
    "rate_ripple": _ripple,
    "encoder_eccentricity": _eccentricity,
    "table_scale": _same("scale", "1"),
    "time_offset": _same("seconds", "s"),
    "clock_skew": _same("share", "1"),
    "accel_axis_skew": _same("step", "s"),
    "dropped_samples": _dropped,
    "gyro_scale_nonlinearity": _gyro_nonlinearity,
    "gyro_scale_asymmetry": _asymmetry,
    "gyro_saturation": _same("limit", "rad/s"),
    "gyro_g2_sensitivity": lambda truth, p: _matrix("M", p["M"], "(rad/s)/(m/s2)2"),
    "gyro_scale_g_dependence": _scale_g,
    "gyro_angular_acceleration": lambda truth, p: _matrix("A", p["A"], "s"),
    "accel_nonlinearity": _accel_nonlinearity,
    "accel_saturation": _same("limit", "m/s2"),
    "temperature_bias": _follows("K"),
    "temperature_scale": _temperature_scale,
    "thermal_transient": _transient,
    "thermal_gradient": _follows("(K/s)"),
    "supply_sensitivity": _follows("V"),
    "magnetic_sensitivity": lambda truth, p: _matrix("M", p["M"], "(rad/s)/T"),
    "bandwidth": _bandwidth,
    "coarse_quantisation": lambda truth, p: {"gyro": (p["gyro"], "rad/s"),
                                             "accel": (p["accel"], "m/s2")},
    "mains_pickup": _mains,
    "hysteresis": lambda truth, p: _vector("amplitude", p["amplitude"], "rad/s")
    | {"angle": (p["angle"], "rad")},
    "bias_step": _step,
    "range_setting": _same("factor", "1"),
    "timestamp_jitter": _jitter,
    "reference_frame": _frame,
}  # fmt: skip


# Stated parameters beside the true ones: how many of the stated 95 % intervals hold the truth.

# What tells which form of an effect was found: parameters of another form mean something else.
FORMS: Mapping[str, Mapping[str, str]] = {
    "gyro_scale_nonlinearity": {"order": "order"},
    "accel_nonlinearity": {"order": "order"},
    "axis_wobble": {"per_turn": "order"},
    "rate_ripple": {"per_turn": "per_turn"},
}
NORMAL_95 = 1.959964  # half the 95 % interval of a normal distribution, in u
AXIS_OF_PLANT = 1.0  # the first table axis has the plant's ripple and eccentricity


@dataclass(frozen=True)
class Compared:
    """A parameter stated and true, in the unit of both; u: standard uncertainty stated."""

    name: str
    unit: str
    found: float
    u: float
    true: float

    @property
    def inside(self) -> bool:
        """Whether the stated 95 % interval holds the truth."""
        return abs(self.found - self.true) <= NORMAL_95 * self.u


def compared(
    truth: Truth, effect: str, stated: Sequence[Mapping[str, Any]]
) -> tuple[list[Compared], list[str]]:
    """Stated parameters beside the true ones, and the names of those that have none beside them.

    stated: name, value, unit and u of each, in the order stated. Left without: another unit,
    another form of the effect, other numbers of lost runs or fixings than there are.
    """
    known = known_parameters(truth, effect)
    pairs: list[Compared] = []
    alone: list[str] = []
    for block in _blocks(stated):
        right = _same_form(truth, effect, block) and _same_count(known, effect, block)
        for each in block:
            true, unit = known.get(each["name"], (None, ""))
            if each["u"] <= 0.0:  # a form, not a number
                continue
            if right and true is not None and unit == each["unit"]:
                pairs.append(Compared(each["name"], unit, each["value"], each["u"], true))
            else:
                alone.append(each["name"])
    return pairs, alone


def _blocks(stated: Sequence[Mapping[str, Any]]) -> list[list[Mapping[str, Any]]]:
    """The parameters of each term: one that comes again begins another."""
    blocks: list[list[Mapping[str, Any]]] = []
    for each in stated:
        if not blocks or any(each["name"] == other["name"] for other in blocks[-1]):
            blocks.append([])
        blocks[-1].append(each)
    return blocks


def _same_form(truth: Truth, effect: str, block: list[Mapping[str, Any]]) -> bool:
    response = {each["name"]: each["value"] for each in block}
    forms = FORMS.get(effect, {}).items()
    if response.get("axis", AXIS_OF_PLANT) != AXIS_OF_PLANT:
        return False
    return all(response.get(name) == truth.effects[effect][true] for name, true in forms)


def _same_count(known: Known, effect: str, block: list[Mapping[str, Any]]) -> bool:
    """As many lost runs, or fixings, as there are: otherwise their numbers mean others."""
    if effect not in ("dropped_samples", "remount_misalignment"):
        return True
    numbers = {each["name"].rsplit("_", 1)[1] for each in block if each["u"] > 0.0}
    return numbers == {name.rsplit("_", 1)[1] for name in known}


# What nobody can beat: the power of a detector that knows an effect's form.


def freedom_of(truth: Truth, effect: str) -> int:
    """How many numbers an effect's form leaves open, at least one."""
    known = known_parameters(truth, effect)
    if known:
        return len(known)
    own = truth.effects[effect]
    return max(1, sum(_count(own.get(name, ())) for name in EFFECTS[effect].sized))


def _count(value: object) -> int:
    return sum(map(_count, value)) if isinstance(value, list | tuple) else 1


def power(z: float, freedom: int) -> float:
    """Probability that χ² of the form's own coordinates, whose mean is `freedom` without and
    freedom + z² with the effect, exceeds what chance does in 1 % of clean recordings.

    The form is known and nothing else is looked for; non-linear parameters count like linear ones.
    """
    bound = float(chi2.isf(FALSE_ALARMS, freedom))
    return float(ncx2.sf(bound, freedom, z * z))
