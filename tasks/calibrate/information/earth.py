"""The g-sensitivity of JJF 2003 without Earth's rotation, and whether the data show any."""

from collections.abc import Mapping

from schemas.calibration import Information, Item
from tasks.calibrate.information.entry import entry
from tasks.specifications.earth_gain import EarthRotationGain, earth_rotation_message
from tasks.words import Message, message

ITEM = "gyro_g_sensitivity"
WITHOUT_EARTH = "gyro_g_sensitivity_without_earth_rotation"
EARTH_ROTATION = "earth_rotation_seen"


def earth_information(
    earth: EarthRotationGain | None, items: Mapping[str, Item]
) -> dict[str, Information]:
    """The gain λ of Earth's rotation, and g-sensitivity less K·ωe·sin φ, (deg/s)/g.

    Nothing where the recording has no g-sensitivity or no latitude.
    """
    item = items.get(ITEM)
    return {**_gain(earth), **separated(item, earth)} if item else {}


def _gain(earth: EarthRotationGain | None) -> dict[str, Information]:
    if earth is None:
        return {}
    text = message(
        "information-earth-gain.text", shown=earth_rotation_message(earth),
        gain=f"{earth.gain:.3f}", spread=f"{2.0 * earth.u:.3f}",
    )  # fmt: skip
    gain = entry(
        "earth-gain", "1", [round(earth.gain, 3)], [earth.u], text,
        elements="λ", without_U=True, about=ITEM,
    )  # fmt: skip
    return {EARTH_ROTATION: gain}


def separated(item: Item, earth: EarthRotationGain | None) -> dict[str, Information]:
    """The value without Earth's rotation; nothing where it is that of the item itself."""
    without = item.value_without_earth_rotation
    if without is None:
        return {}
    off = max(
        (
            abs(value - other) / U
            for element, other in without.items()
            if other is not None
            and (value := item.value[element]) is not None
            and (U := item.U[element])
        ),
        default=0.0,
    )
    if not off:
        return {}
    text = message("information-without-earth.text", difference=_difference(off, earth))
    u = item.u_without_earth_rotation or dict.fromkeys(without)
    numbers = [*without.values()], [*u.values()]
    shown = entry(
        "without-earth", item.unit, *numbers, text, elements=without, k=item.k, about=ITEM
    )
    return {WITHOUT_EARTH: shown}


def _difference(off: float, earth: EarthRotationGain | None) -> Message:
    """What the difference of both values, so many times U, means."""
    state = earth.state if earth and earth.state in ("present", "not_shown") else "unknown"
    return message(f"information-earth-{state.replace('_', '-')}", times=f"{off:.2g}")
