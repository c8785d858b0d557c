"""Stated parameters beside the true ones: how many of the stated 95 % intervals hold the truth."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tests.proof.trial.parameters import Known, Truth, known_parameters

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
