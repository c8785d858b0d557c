"""What the reader of a joint calibration must know: Earth's rotation, scatter, the reference."""

import numpy as np

from schemas.calibration import Remark
from schemas.recording import AXES
from tasks.segments.summarise import CHANNELS
from tasks.specifications.earth_rotation import earth_rotation_message
from tasks.specifications.evidence import Evidence
from tasks.specifications.joint.gravity_fit import GravityFit
from tasks.specifications.joint.moves import MovesFit
from tasks.specifications.joint.segment_motion import SegmentMotion
from tasks.specifications.joint.solution import Joint
from tasks.specifications.linear import BLOCKING_EXCESS
from tasks.words import texts

EARTH_NOT_REMOVED = Remark(
    code="earth_not_removed",
    en="The latitude is not told: Earth's rotation was not removed, and the diagonal of the "
    "g-sensitivity contains its vertical part.",
    zh="未给出纬度：未扣除地球自转，g 敏感系数对角元含其竖直分量。",
)


def earth_remarks(evidence: Evidence, joint: Joint, motion: SegmentMotion) -> list[Remark]:
    """What was done with Earth's rotation."""
    latitude = evidence.latitude_deg
    if not motion.gyro.any():
        return []
    if latitude is None:
        return [EARTH_NOT_REMOVED]
    shown = texts(earth_rotation_message(joint.earth))
    en, zh = shown["en"], shown["zh"]
    if joint.earth and joint.earth.refuted:
        return [
            Remark(
                code="earth_rotation_not_shown",
                en=f"{en}. It was not taken off: bias and g-sensitivity are as the data have them.",
                zh=f"{zh}。未予扣除：偏值与 g 敏感系数即为数据所示。",
            )
        ]
    remarks = [
        Remark(
            code="earth_removed",
            en=f"{en}. At {latitude:g}° latitude it was taken off as a known input: bias and "
            "g-sensitivity are given without it.",
            zh=f"{zh}。已按纬度 {latitude:g}° 作为已知输入扣除：偏值与 g 敏感系数均为扣除后的值。",
        )
    ]
    if (motion.zero & ~np.isfinite(motion.mean.north).all(axis=1)).any():
        remarks.append(
            Remark(
                code="north_unknown",
                en="Where north lay in the rests is not told: only the vertical part of Earth's "
                "rotation was removed; the horizontal part cancels between two headings 180° "
                "apart and is else in the bias.",
                zh="静止位置的北向未知：仅扣除地球自转的竖直分量；水平分量在相差 180° 的两个方位间"
                "抵消，否则留在偏值中。",
            )
        )
    undetermined = [a for a in AXES if not np.isfinite(joint.estimates["gyro_matrix"][a * 2].value)]
    if undetermined:
        remarks.append(
            Remark(
                code="scale_factor_assumed",
                en="Where this run gives no gyro scale factor, 1 was taken to remove Earth's "
                "rotation.",
                zh="本次未得陀螺标度因数处，扣除地球自转时取 1。",
            )
        )
    return remarks


def scatter_remarks(joint: Joint) -> list[Remark]:
    """One remark on the channels that the model does not follow within their noise."""
    exceeding = np.flatnonzero(joint.excess > 1.0)
    if not len(exceeding):
        return []
    listed = ", ".join(f"{CHANNELS[i]} {joint.excess[i]:.1f}" for i in exceeding)
    return [
        Remark(
            code="excess_scatter",
            en=f"The segments disagree with the model more than the noise explains ({listed} "
            "times); the uncertainties were enlarged by as much.",
            zh=f"各段与模型的偏差超过噪声（{listed} 倍），不确定度已按此放大。",
            blocks_pass=bool(joint.excess.max() > BLOCKING_EXCESS),
        )
    ]


def reference_remark() -> Remark:
    return Remark(
        code="gravity_alone",
        en="No table and no labels: gravity was the only reference, in rests found in the data.",
        zh="无转台数据和分段标注：仅以重力为参考，静止段由数据自动识别。",
        blocks_pass=True,
    )


def fit_remarks(fitted: GravityFit | None, moved: MovesFit | None) -> list[Remark]:
    """How well the rests and the moves follow the model."""
    remarks = []
    if fitted is not None:
        rms = float(np.sqrt(np.mean(fitted.misses**2)))
        factor = fitted.excess.factor
        more, more_zh = (
            (
                f", {factor:.1f} times what the noise explains; the uncertainties were enlarged by "
                "as much",
                f"，为噪声的 {factor:.1f} 倍，不确定度已按此放大",
            )
            if factor > 1.0
            else (", no more than the noise explains", "，未超过噪声")
        )
        remarks.append(
            Remark(
                code="gravity_residual",
                en=f"The specific force of the {len(fitted.misses)} rests misses gravity by "
                f"{rms:.2g} m/s² (rms){more}.",
                zh=f"{len(fitted.misses)} 个静止位置的比力与重力之差为 {rms:.2g} m/s²（均方根）"
                f"{more_zh}。",
            )
        )
    if moved is not None:
        angle = np.degrees(moved.miss)
        remarks.append(
            Remark(
                code="moves_residual",
                en=f"Over {moved.moves} moves the integrated gyro misses the vertical by "
                f"{angle:.2g}° (rms); the gyro's uncertainties are from this scatter.",
                zh=f"{moved.moves} 次运动中，陀螺积分与竖直方向之差为 {angle:.2g}°（均方根），"
                "陀螺的不确定度由该离散性得到。",
            )
        )
    return remarks


def hand_earth_remark(evidence: Evidence) -> list[Remark]:
    if evidence.latitude_deg is not None:
        return [
            Remark(
                code="north_unknown",
                en="Only the vertical part of Earth's rotation was removed: where north lay in the "
                "rests is not known.",
                zh="仅扣除地球自转的竖直分量：静止位置的北向未知。",
            )
        ]
    return [EARTH_NOT_REMOVED]
