"""What an answer about a recording of the virtual station is worth."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from tests.proof.station.case import Case

UNNAMED = "unnamed"
LOW_PASS, DELAY = "bandwidth", "time_offset"
# What is true of every unit of the station: its accelerometers sit beside the axes, its biases
# follow its temperature, and the Earth turns.
ALWAYS = ("lever_arm", "size_effect", "temperature_bias", "earth_rotation")
WITHIN = 3.0  # standard uncertainties
NEGLIGIBLE_S = 1e-4  # that a value may be off by all the same
Judged = Literal["right", "group", "not told", "wrong value", "absent", "invented"]
Finding = Mapping[str, Any]


@dataclass(frozen=True)
class Score:
    """low_pass, delay: how each was told. wrong: names that are not true of the unit."""

    case: Case
    names: tuple[str, ...]
    wrong: tuple[str, ...]
    low_pass: Judged
    delay: Judged
    seconds: float
    failed: str | None

    @property
    def is_silent(self) -> bool:
        """Whether a low-pass or a delay is not told."""
        return "not told" in (self.low_pass, self.delay)

    @property
    def is_right(self) -> bool:
        """No name is wrong, and low-pass and delay are told or cannot be seen."""
        fine = {"right", "group", "absent"}
        filtered = self.low_pass in fine or (self.low_pass == "not told" and _is_hidden(self.case))
        return self.failed is None and not self.wrong and filtered and self.delay in fine


def score(case: Case, answer: Mapping[str, Any]) -> Score:
    """The score of what answer.json says."""
    findings: Sequence[Finding] = answer.get("findings", ())
    named = [one for one in findings if one["effect"] != UNNAMED]
    pairs = ((LOW_PASS, case.has_low_pass), (DELAY, case.has_delay))
    true = {effect for effect, has in pairs if has}
    wrong = [one for one in named if not _is_true(case, one, true)]
    return Score(
        case,
        tuple("/".join(one["group"]) or one["effect"] for one in findings),
        tuple(one["effect"] for one in wrong),
        _declared(LOW_PASS, case, named),
        _declared(DELAY, case, named),
        answer["seconds"],
        answer.get("failed"),
    )


def _is_hidden(case: Case) -> bool:
    """Whether the low-pass is of accelerometers alone that hardly feel a change: those of an AHRS
    upright on a single axis read the same at all angles, ten times a second.
    """
    return case.procedure == "jjf1536"


def _is_true(case: Case, finding: Finding, true: set[str]) -> bool:
    if finding["group"]:
        return not true.isdisjoint(finding["group"]) or not set(ALWAYS).isdisjoint(finding["group"])
    return finding["effect"] in true or (
        finding["effect"] in ALWAYS and _as_large_as_true(case, finding)
    )


def _declared(effect: str, case: Case, named: Sequence[Finding]) -> Judged:
    has = case.has_low_pass if effect == LOW_PASS else case.has_delay
    alone = [one for one in named if one["effect"] == effect and not one["group"]]
    grouped = [one for one in named if effect in one["group"]]
    if grouped:
        right = all(_common_part_is_true(case, one) for one in grouped)
        return ("group" if has else "absent") if right else "wrong value"
    if not has:
        return "invented" if alone else "absent"
    if not alone:
        return "not told"
    true = _times(case) if effect == LOW_PASS else {"seconds": case.delay_s}
    right = all(_agrees(one["parameters"], true) for one in alone)
    return "right" if right else "wrong value"


def _times(case: Case) -> dict[str, float]:
    """Time constants by the names of the effect's parameters, s."""
    gyro, accel = case.time_constants_s
    if np.isclose(gyro, accel, rtol=1e-2):  # one corner for all says it, too
        return {"time_constant": gyro, "gyro_time_constant": gyro, "accel_time_constant": accel}
    return {"gyro_time_constant": gyro, "accel_time_constant": accel}


def _common_part_is_true(case: Case, finding: Finding) -> bool:
    gyro, accel = case.group_delays_s
    true = {"gyro_group_delay": gyro, "accel_group_delay": accel}
    return _agrees(finding["common"], true)


def _agrees(parameters: Sequence[Mapping[str, Any]], true: Mapping[str, float]) -> bool:
    """Whether the parameters that a finding states hold the truth."""
    response = [(p["value"] - true[p["name"]], p["u"]) for p in parameters if p["name"] in true]
    return bool(response) and all(abs(off) <= WITHIN * u + NEGLIGIBLE_S for off, u in response)


def _as_large_as_true(case: Case, finding: Finding) -> bool:
    """Whether a true effect is stated with the size that the unit has it in, to a factor of two."""
    unit = case.station.unit
    largest = {
        "lever_arm": float(np.abs(unit.places_m).max()),
        "size_effect": float(np.abs(unit.places_m).max()),
        "temperature_bias": float(np.abs(unit.accel.bias_per_kelvin).max()),
        "earth_rotation": np.inf,
    }[finding["effect"]]
    return all(abs(p["value"]) <= 2.0 * largest + WITHIN * p["u"] for p in finding["parameters"])
