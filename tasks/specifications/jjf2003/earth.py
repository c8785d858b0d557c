"""Earth's rotation in the g-sensitivity of eq. (7), and the value without it."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from schemas.calibration import Remark
from schemas.recording import AXES, Recording
from tasks.motion.table import EARTH_RATE
from tasks.specifications.earth_seen import State, earth_seen, said
from tasks.specifications.evaluation import Evaluation
from tasks.specifications.evidence import Evidence
from tasks.specifications.jjf2003.positions import is_paired
from tasks.specifications.measured import UNDETERMINED, Measured
from tasks.specifications.parts import DEG, MATRIX
from tasks.uncertainty.type_b import earth_removed

# Its vertical part at the latitude, and the latitude, stand in the braces.
CONSEQUENCES: dict[State, tuple[str, str]] = {
    "seen": (
        "By eq. (7) the diagonal of the g-sensitivity contains {} of it at {:g}° latitude; the "
        "value without it stands beside.",
        "按式(7)，g 敏感系数对角元含地球自转 {}（纬度 {:g}°）；旁列扣除后的值。",
    ),
    "not_visible": (
        "A unit at rest on the Earth reads {} on the diagonal by eq. (7) at {:g}° latitude; the "
        "value with this taken off stands beside.",
        "静止于地球上的器件，按式(7)对角元应含 {}（纬度 {:g}°）；旁列扣除后的值。",
    ),
    "not_shown": (
        "The value without Earth's rotation has {} ({:g}° latitude) taken off the diagonal all "
        "the same, as for a station that turns with the Earth. Do not use it for simulated or "
        "compensated data, from which it would be removed twice: their value is that by eq. (7).",
        "“扣除地球自转的值”仍从对角元扣除 {}（纬度 {:g}°），即按随地球转动的装置处理。"
        "对仿真或已补偿的数据不得使用，否则重复扣除；此时应使用式(7)的值。",
    ),
    "odd": (
        "A unit at rest on the Earth reads {} on the diagonal by eq. (7) at {:g}° latitude; the "
        "value with this taken off stands beside.",
        "静止于地球上的器件，按式(7)对角元应含 {}（纬度 {:g}°）；旁列扣除后的值。",
    ),
}


def without_earth(
    recording: Recording,
    evidence: Evidence,
    positions: dict[str, tuple[int, ...]],
    found: Mapping[str, Measured],
    gyro_k: np.ndarray,
    evaluation: Evaluation,
) -> tuple[dict[str, Measured], tuple[str, str] | None]:
    """G with the vertical part of Earth's rotation removed, and why elements are undetermined.

    The vertical part reads K·ωe·sin φ along the axis up; its budget has the latitude's line
    beside those of the clause's value. The horizontal part cancels in positions held at two
    headings 180° apart; in others it is not known, and reaches the gyros that are not vertical.
    """
    latitude = recording.manifest.station.latitude_deg
    if latitude is None:
        why = (
            "without Earth rotation: the latitude is not told",
            "扣除地球自转的值：未给出纬度",
        )
        return dict.fromkeys(found, UNDETERMINED), why
    k = np.where(np.isfinite(gyro_k), gyro_k, np.eye(3))
    phi = float(np.radians(latitude))
    single = [up for up, indices in positions.items() if not is_paired(evidence, indices)]
    unknown = {AXES.index(up[1]) for up in single}
    still = {}
    for i, j in MATRIX:
        element = AXES[i] + AXES[j]
        seen = found[element]
        lines = earth_removed(evaluation.equipment, float(k[i, j]), phi)
        value = seen.value - float(k[i, j]) * EARTH_RATE * float(np.sin(phi))
        less = replace(seen, value=value).with_lines(*lines)
        still[element] = UNDETERMINED if i != j and j in unknown else less
    if not single:
        return still, None
    return still, (
        f"without Earth rotation, off the diagonal: {', '.join(single)} held at one heading only, "
        "so its horizontal part is not known",
        f"扣除地球自转的非对角元：{', '.join(single)} 仅在一个方位测量，水平分量未知",
    )


def earth_remarks(recording: Recording, evidence: Evidence, gyro_k: np.ndarray) -> Iterator[Remark]:
    """Says what Earth's rotation does to the diagonal by eq. (7), as far as the data show it."""
    latitude = recording.manifest.station.latitude_deg
    if latitude is None:
        return
    rate = DEG * EARTH_RATE * np.sin(np.radians(latitude))
    seen = earth_seen(recording, evidence)
    state = seen.state if seen else "not_visible"
    (en, zh), (then_en, then_zh) = said(seen), CONSEQUENCES[state]
    much = f"{rate:.5f} (deg/s)/g", f"{rate:.5f} (°/s)/g"
    yield Remark(
        code="earth_rotation" if state == "seen" else f"earth_rotation_{state}",
        en=f"{en}. {then_en.format(much[0], latitude)}",
        zh=f"{zh}。{then_zh.format(much[1], latitude)}",
    )
    if not np.isfinite(gyro_k).all():
        yield Remark(
            code="scale_factor_assumed",
            en="Where this run gives no gyro scale factor, 1 was taken to remove Earth's rotation.",
            zh="本次未得陀螺标度因数处，扣除地球自转时取 1。",
        )
