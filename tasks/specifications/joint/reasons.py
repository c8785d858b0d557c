"""Why elements of a joint calibration are null: what would determine them."""

from collections.abc import Mapping, Sequence

import numpy as np

from schemas.discrepancy import Statement
from schemas.recording import AXES
from tasks.specifications.estimate import ItemEstimate
from tasks.specifications.evidence import UPS, Evidence
from tasks.specifications.joint.gravity_fit import FEWEST_RESTS
from tasks.specifications.joint.segment_motion import SegmentMotion

Reasons = dict[str, Statement]


def level_unknown(motion: SegmentMotion, evidence: Evidence, up: str) -> bool:
    """Whether a rest with this axis up feels an unknown horizontal part of Earth's rotation."""
    of_face = [i for i, shown in enumerate(evidence.up) if shown == up]
    return bool((motion.zero & motion.level_unknown)[of_face].any())


def table_reasons(
    items: Mapping[str, ItemEstimate], motion: SegmentMotion, evidence: Evidence
) -> Reasons:
    """Why elements are null: what would determine them."""
    absent = [up for up in UPS if not any(s == up and z for s, z in _rests(evidence, motion.zero))]
    no_rest = [
        up for up in UPS if not any(s == up and a for s, a in _rests(evidence, motion.accel))
    ]
    unturned = [axis for axis, turned in zip(AXES, motion.turned, strict=True) if not turned]
    unfelt = [axis for axis in AXES if not any(motion.accel[i] for i in evidence.points[axis])]
    causes = {
        "gyro_scale_factor": _not_turned(unturned, "gyro"),
        "gyro_cross_coupling": _not_turned(unturned, "gyro"),
        "gyro_fit_offset": _not_turned(
            [a for a in AXES if not any(motion.gyro[i] for i in evidence.points[a])], "gyro"
        ),
        "gyro_bias": _not_rested(absent, "gyro"),
        "gyro_g_sensitivity": _not_rested(absent, "gyro"),
        "accel_scale_factor": _not_rested(no_rest, "accel"),
        "accel_cross_coupling": _not_rested(no_rest, "accel"),
        "accel_bias": _not_rested(no_rest, "accel"),
        "accel_rate_sensitivity": _not_turned(unfelt, "accel"),
    }
    if evidence.gravity is None:
        why = ("the local gravity is not told", "未给出当地重力加速度")
        causes["accel_scale_factor"] = causes["accel_cross_coupling"] = why
    level = ", ".join(up for up in UPS if level_unknown(motion, evidence, up))
    reasons = {}
    for name, item in items.items():
        null = item.undetermined
        if not null:
            continue
        why_en, why_zh = causes[name]
        if name == "gyro_g_sensitivity" and level:
            known = (why_en, why_zh) != NOT_TOLD_APART
            why_en = (f"{why_en}; " if known else "") + (
                f"off the diagonal, {level} held at one heading only and north is not told, so the "
                "horizontal part of Earth's rotation is not known"
            )
            why_zh = (f"{why_zh}；" if known else "") + (
                f"非对角元：{level} 仅在一个方位测量且北向未知，地球自转水平分量未知"
            )
        shown = ", ".join(null)
        reasons[name] = Statement(en=f"{shown}: {why_en}", zh=f"{shown}：{why_zh}")
    return reasons


def _rests(evidence: Evidence, used: np.ndarray) -> list[tuple[str | None, bool]]:
    return [
        (up, bool(flag) and segment.segment.kind == "static")
        for up, flag, segment in zip(evidence.up, used, evidence.segments, strict=True)
    ]


NOT_TOLD_APART = (
    "the segments of this run do not tell it apart from the rest",
    "本次各段数据不足以将其与其他参数区分",
)


def _not_turned(axes: Sequence[str], triad: str) -> tuple[str, str]:
    if not axes:
        return NOT_TOLD_APART
    listed = ", ".join(axes)
    zh = {"gyro": "陀螺", "accel": "加速度计"}[triad]
    known, known_zh = ("fewer than two known rates", "少于两个")
    if triad == "accel":
        known, known_zh = ("no known rate about a known vertical", "缺失")
    return (
        f"{known} about {listed} with the {triad} triad recorded",
        f"绕 {listed} 轴转动且记录了{zh}数据的已知角速率段{known_zh}",
    )


def _not_rested(ups: Sequence[str], triad: str) -> tuple[str, str]:
    if not ups:
        return NOT_TOLD_APART
    listed = ", ".join(ups)
    zh = {"gyro": "陀螺", "accel": "加速度计"}[triad]
    return (
        f"no rest with {listed} up and the {triad} triad recorded",
        f"缺少 {listed} 朝天且记录了{zh}数据的静止位置",
    )


def hand_reasons(
    evidence: Evidence, items: Mapping[str, ItemEstimate], rests_fitted: bool, rests: int
) -> Reasons:
    """Why elements are null."""
    causes = dict.fromkeys(items, (
        "no nine moves between rests turn the unit about all of its axes with both triads recorded",
        "没有九次以上、绕各轴转动且记录了两组数据的静止位置间运动",
    ))  # fmt: skip
    causes["accel_cross_coupling"] = (
        "zero by definition, the accelerometers' own axes are the reference",
        "按定义为零，以加速度计敏感轴为基准",
    )
    causes["gyro_fit_offset"] = causes["accel_rate_sensitivity"] = (
        "no known rate was held",
        "没有已知的恒定角速率",
    )
    if not rests_fitted:
        none = (
            f"{rests} rests with the accelerometers; {FEWEST_RESTS} or more at attitudes all "
            "around are needed",
            f"有加速度计数据的静止位置 {rests} 个；需 {FEWEST_RESTS} 个以上、姿态遍布各方向",
        )
        if evidence.gravity is None:
            none = ("the local gravity is not told", "未给出当地重力加速度")
        causes = dict.fromkeys(items, none)
    reasons = {}
    for name, item in items.items():
        null = ", ".join(item.undetermined)
        if null:
            en, zh = causes[name]
            reasons[name] = Statement(en=f"{null}: {en}", zh=f"{null}：{zh}")
    return reasons
