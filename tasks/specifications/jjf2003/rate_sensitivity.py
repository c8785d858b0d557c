"""7.2.5: what turning adds to the accelerometers, p by eq. (12) and (13)."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from schemas.calibration import Remark
from schemas.recording import AXES, Axis
from tasks.segments.summarise import ACCEL_COLUMNS
from tasks.specifications.evaluation import Evaluation, make_item
from tasks.specifications.evidence import Evidence
from tasks.specifications.measured import UNDETERMINED, Measured, measured, u_of_means
from tasks.specifications.parts import OFF_DIAGONAL, Part
from tasks.uncertainty import type_b

CLAUSE = "JJF 2003-2022, 7.2.5.2 eq. (12), (13)"
READINGS = (
    "jjf2003.p_turning",
    "jjf2003.p_sign",
    "jjf2003.p_lever_arm",
    "jjf2003.p_rates",
    "jjf2003.p_unit",
)
SAME_RATE = 0.99  # points within 1 % of the largest rate count as the largest


@dataclass(frozen=True)
class Run:
    """Turning at the largest rate with one axis up, and the rests with the same axis up."""

    turning: tuple[int, ...]
    rests: tuple[int, ...]


def rate_sensitivity_item(evidence: Evidence, gravity: float, evaluation: Evaluation) -> Part:
    """p (3, 3, metres; diagonal not defined): rest minus turning over ω², eq. (12), (13).

    gravity: m/s², of which only the sensitivity to a tilt is made.
    """
    found = {AXES[i] + AXES[j]: UNDETERMINED for i, j in OFF_DIAGONAL}
    missing: list[tuple[str, str]] = []
    remarks: list[Remark] = []
    for j, axis in enumerate(AXES):
        runs, why = _runs(evidence, axis)
        if why is not None:
            missing.append((f"{axis}: {why[0]}", f"{axis}：{why[1]}"))
            continue
        for i in range(3):
            if i != j:
                found[AXES[i] + AXES[j]] = _difference(evidence, i, runs, gravity, evaluation)
        remarks.extend(_one_sided(evidence, axis, runs))
    name = "accel_rate_sensitivity"
    item = make_item(evaluation, name, found, "m", CLAUSE, READINGS)
    opposite = {e: None if value is None else -value for e, value in item.value.items()}
    item = item.model_copy(update={"value_model": opposite})
    reason = ("; ".join(en for en, _ in missing), "；".join(zh for _, zh in missing))
    return Part({name: item}, {name: reason} if missing else {}, tuple(remarks))


def _runs(evidence: Evidence, axis: Axis) -> tuple[tuple[Run, ...], tuple[str, str] | None]:
    """The runs about each vertical direction of an axis that has rests, or why there are none."""
    points = [i for i in evidence.points[axis] if evidence.segments[i].has_accel]
    if not points:
        return (), (
            f"no usable rate about {axis} with the accelerometers recorded",
            f"没有绕 {axis} 轴可用的角速率点且记录了加速度计的数据",
        )
    vertical = [i for i in points if (evidence.up[i] or "")[1:] == axis]
    if not vertical:
        return (), (
            f"gravity does not lie along {axis} while turning, or the recording does not tell",
            f"转动时重力不沿 {axis} 轴，或记录未说明",
        )
    largest = max(abs(evidence.rate[i]) for i in vertical)
    fast = [i for i in vertical if abs(evidence.rate[i]) >= SAME_RATE * largest]
    runs = []
    for up in sorted({str(evidence.up[i]) for i in fast}):
        rests = [i for i in evidence.rests.get(up, ()) if evidence.segments[i].has_accel]
        beside = [i for i in rests if evidence.segments[i].segment.item == "rate_sensitivity"]
        turning = tuple(i for i in fast if evidence.up[i] == up)
        if rests:
            runs.append(Run(turning, tuple(beside or rests)))
    if not runs:
        return (), (f"no rest with {axis} up or down", f"缺少 {axis} 轴朝天或朝地的静止数据")
    return tuple(runs), None


def _difference(
    evidence: Evidence,
    channel: int,
    runs: tuple[Run, ...],
    gravity: float,
    evaluation: Evaluation,
) -> Measured:
    """Rest minus turning over ω² for one accelerometer (m).

    Each run has its own rests, because gravity reads differently up and down. Each direction of
    turning counts once, so that what changes its sign with the direction cancels.
    """
    rest, turning = np.zeros((2, len(evidence.segments)))
    squares = []
    for run in runs:
        directions = _directions(evidence, run)
        square = np.mean([np.mean(evidence.rate[direction] ** 2) for direction in directions])
        share = 1.0 / square / len(runs)
        squares.append(square)
        for i in run.rests:
            rest[i] += share / len(run.rests)
        for direction in directions:
            for i in direction:
                turning[i] += share / len(directions) / len(direction)
    column = ACCEL_COLUMNS.start + channel
    found = measured(evidence, column, rest - turning)
    rate = float(np.sqrt(np.mean(squares)))
    lines = type_b.accel_rate_sensitivity(evaluation.equipment, found.value, rate, gravity)
    apart = u_of_means(evidence, column, np.array([rest, turning]))
    return Measured(found.value, (*found.lines, *lines), tuple(map(float, apart)))


def _directions(evidence: Evidence, run: Run) -> list[list[int]]:
    both = [[i for i in run.turning if evidence.rate[i] * sign > 0] for sign in (1, -1)]
    return [direction for direction in both if direction]


def _one_sided(evidence: Evidence, axis: Axis, runs: tuple[Run, ...]) -> Iterator[Remark]:
    """Where a run has one direction only, or rests on one side of it only."""
    if any(len(_directions(evidence, run)) < 2 for run in runs):
        yield Remark(
            code="p_one_direction",
            en=f"{axis} axis: p rests on one direction of turning; what changes its sign with the "
            "direction does not cancel.",
            zh=f"{axis} 轴：p 仅由一个转动方向得到，随方向变号的影响未抵消。",
            blocks_pass=True,
        )
    start = [segment.t_start for segment in evidence.segments]
    for run in runs:
        first, last = min(start[i] for i in run.turning), max(start[i] for i in run.turning)
        before = any(start[i] < first for i in run.rests)
        after = any(start[i] > last for i in run.rests)
        if not (before and after):
            yield Remark(
                code="p_rest_on_one_side",
                en=f"{axis} axis: p has no rest {'after' if before else 'before'} the turning; a "
                "drift of the accelerometers does not cancel.",
                zh=f"{axis} 轴：p 缺少转动{'后' if before else '前'}的静止数据，"
                "加速度计漂移未抵消。",
                blocks_pass=True,
            )
