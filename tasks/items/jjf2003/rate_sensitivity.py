"""7.2.5: what turning adds to the accelerometers, p by eq. (12) and (13)."""

import numpy as np

from schemas.recording import AXES, Axis
from tasks.items.evidence import Evidence
from tasks.items.parts import OFF_DIAGONAL, Estimate, Part, elements, make_item
from tasks.segments.summarise import ACCEL_COLUMNS

CLAUSE = "JJF 2003-2022, 7.2.5.2 eq. (12), (13)"
READINGS = (
    "jjf2003.p_turning",
    "jjf2003.p_sign",
    "jjf2003.p_lever_arm",
    "jjf2003.p_rates",
    "jjf2003.p_unit",
)
SAME_RATE = 0.99  # points within 1 % of the largest rate count as the largest


def rate_sensitivity_item(evidence: Evidence) -> Part:
    """p (3, 3, metres; diagonal not defined): rest minus turning over ω², eq. (12), (13)."""
    p = Estimate(np.full((3, 3), np.nan), np.full((3, 3), np.nan))
    missing: list[tuple[str, str]] = []
    for j, axis in enumerate(AXES):
        turning, rests, why = _runs(evidence, axis)
        if why is not None:
            missing.append((f"{axis}: {why[0]}", f"{axis}：{why[1]}"))
            continue
        for i in range(3):
            if i != j:
                p.value[i, j], p.u[i, j] = _difference(evidence, i, turning, rests)
    item = make_item(p, "m", CLAUSE, OFF_DIAGONAL, READINGS).model_copy(
        update={"value_model": elements(-p.value, OFF_DIAGONAL)}
    )
    name = "accel_rate_sensitivity"
    reason = ("; ".join(en for en, _ in missing), "；".join(zh for _, zh in missing))
    return Part({name: item}, {name: reason} if missing else {})


def _runs(evidence: Evidence, axis: Axis) -> tuple[list[int], list[int], tuple[str, str] | None]:
    """Points at the largest rate about a vertical axis, the rests beside them, or why not."""
    points = [i for i in evidence.points[axis] if evidence.segments[i].has_accel]
    if not points:
        return (
            [],
            [],
            (
                f"no turning about {axis} with the accelerometers recorded",
                f"没有绕 {axis} 轴转动且记录了加速度计的数据",
            ),
        )
    vertical = [i for i in points if (evidence.up[i] or "")[1:] == axis]
    if not vertical:
        return (
            [],
            [],
            (
                f"the {axis} axis was not vertical while turning, or the recording does not tell",
                f"转动时 {axis} 轴未处于竖直，或记录未说明",
            ),
        )
    largest = max(abs(evidence.rate[i]) for i in vertical)
    turning = [i for i in vertical if abs(evidence.rate[i]) >= SAME_RATE * largest]
    up = evidence.up[turning[0]]
    rests = [i for i in evidence.rests.get(str(up), ()) if evidence.segments[i].has_accel]
    beside = [i for i in rests if evidence.segments[i].segment.item == "rate_sensitivity"]
    if not rests:
        return [], [], (f"no rest with {up} up", f"缺少 {up} 朝天的静止数据")
    return turning, beside or rests, None


def _difference(
    evidence: Evidence, channel: int, turning: list[int], rests: list[int]
) -> tuple[float, float]:
    """Rest minus turning over ω² for one accelerometer (m), and its standard uncertainty.

    Each direction counts once, so that what changes its sign with the direction cancels.
    """
    indices = [*rests, *turning]
    operator = np.zeros(len(indices))
    operator[: len(rests)] = 1.0 / len(rests)
    directions = [[i for i in turning if evidence.rate[i] * sign > 0] for sign in (1, -1)]
    present = [direction for direction in directions if direction]
    squares = np.mean([np.mean(evidence.rate[direction] ** 2) for direction in present])
    for direction in present:
        for i in direction:
            operator[len(rests) + turning.index(i)] = -1.0 / len(present) / len(direction)
    column = ACCEL_COLUMNS.start + channel
    covariance = evidence.covariance(column)[np.ix_(indices, indices)]
    value = operator @ evidence.means[indices, column] / squares
    return float(value), float(np.sqrt(max(operator @ covariance @ operator, 0.0)) / squares)
