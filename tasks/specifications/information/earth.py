"""The g-sensitivity of JJF 2003 without Earth's rotation, and whether the data show any."""

from collections.abc import Mapping

from schemas.calibration import Information, Item
from schemas.recording import Recording
from tasks.specifications.earth_seen import EarthSeen, earth_seen, said
from tasks.specifications.evidence import Evidence

ITEM = "gyro_g_sensitivity"
NAME = "gyro_g_sensitivity_without_earth_rotation"
SEEN = "earth_rotation_seen"


def earth_information(
    recording: Recording, evidence: Evidence, items: Mapping[str, Item]
) -> dict[str, Information]:
    """The gain λ of Earth's rotation, and g-sensitivity less K·ωe·sin φ, (deg/s)/g.

    Nothing where the recording has no g-sensitivity or no latitude.
    """
    item = items.get(ITEM)
    if item is None:
        return {}
    seen = earth_seen(recording, evidence)
    return {**_gain(seen), **separated(item, seen)}


def _gain(seen: EarthSeen | None) -> dict[str, Information]:
    if seen is None:
        return {}
    en, zh = said(seen)
    return {
        SEEN: Information(
            title="Gain of Earth's rotation in the rests",
            title_zh="静止数据中地球自转的增益",
            unit="1",
            value={"λ": seen.gain},
            u={"λ": seen.u},
            U={"λ": 2.0 * seen.u},
            about=ITEM,
            en=f"{en}.",
            zh=f"{zh}。",
        )
    }


def separated(item: Item, seen: EarthSeen | None) -> dict[str, Information]:
    """The value without Earth's rotation; nothing where it is that of the item itself."""
    still = item.value_without_earth_rotation
    if still is None:
        return {}
    off = max(
        (
            abs(value - other) / U
            for element, other in still.items()
            if other is not None
            and (value := item.value[element]) is not None
            and (U := item.U[element])
        ),
        default=0.0,
    )
    if not off:
        return {}
    en, zh = _difference(off, seen)
    return {
        NAME: Information(
            title="Gyro g-sensitivity without Earth's rotation",
            title_zh="扣除地球自转的陀螺加速度敏感系数",
            unit=item.unit,
            value=still,
            u=item.u_without_earth_rotation,
            U=item.U_without_earth_rotation,
            k=item.k,
            about=ITEM,
            en="The vertical part of Earth's rotation, ω_e·sin φ, is taken off the diagonal; "
            f"{en} U is evaluated as the item's.",
            zh=f"已从对角元扣除地球自转的竖直分量 ω_e·sin φ；{zh}U 的评定同该项结果。",
        )
    }


def _difference(off: float, seen: EarthSeen | None) -> tuple[str, str]:
    """What the difference of both values, so many times U, means."""
    if seen is not None and seen.state == "seen":
        return (
            f"the value by eq. (7) contains it and is off by up to {off:.2g} times its U.",
            f"式(7)的值含该分量，最多偏离 U 的 {off:.2g} 倍。",
        )
    if seen is not None and seen.state == "not_shown":
        return (
            f"this moves it by up to {off:.2g} times U, although the data do not show it: not to "
            "be used for simulated or compensated data, from which it would be removed twice.",
            f"由此最多改变 U 的 {off:.2g} 倍，而数据中没有地球自转：仿真或已补偿的数据不得"
            "使用该值，否则重复扣除。",
        )
    return (
        f"this moves it by up to {off:.2g} times U. Whether the value by eq. (7) has it in it the "
        "data alone do not tell.",
        f"由此最多改变 U 的 {off:.2g} 倍。仅凭数据不能判断式(7)的值是否含该分量。",
    )
