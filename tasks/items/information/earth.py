"""The g-sensitivity of JJF 2003 without Earth's rotation, beside the value by eq. (7)."""

from collections.abc import Mapping

from schemas.calibration import Information, Item

ITEM = "gyro_g_sensitivity"
NAME = "gyro_g_sensitivity_without_earth_rotation"


def earth_information(items: Mapping[str, Item]) -> dict[str, Information]:
    """g-sensitivity less K·ωe·sin φ, (deg/s)/g.

    Nothing where the latitude is not told, or where the item's own value is without it.
    """
    item = items.get(ITEM)
    still = item.value_without_earth_rotation if item else None
    if item is None or still is None:
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
            en="The vertical part of Earth's rotation, ω_e·sin φ, is taken off the diagonal; the "
            f"value by eq. (7) contains it and is off by up to {off:.2g} times its U. U is "
            "evaluated as the item's.",
            zh="已从对角元扣除地球自转的竖直分量 ω_e·sin φ；式(7)的值含该分量，"
            f"最多偏离 U 的 {off:.2g} 倍。U 的评定同该项结果。",
        )
    }
