"""The conditions of the measurement, as the segments that were used and the manifest tell them."""

import math
from dataclasses import dataclass

from schemas.calibration import Calibration, SegmentUsed
from schemas.recording import AXES, Axis, Manifest
from tasks.certificate.conditions_ahrs import ahrs_fields
from tasks.certificate.fields import NOT_GIVEN, Field, given, number
from tasks.certificate.names import Pair
from tasks.certificate.typography import pair

FULL_SCALE = 0.999  # of the unit's largest input rate counts as that rate
UNTOLD_RANGE = (
    "未提供被校对象的最大输入角速率，故未核查速率点是否包括该值。",
    "The unit's largest input rate is not told, so whether it was included was not checked.",
)


@dataclass(frozen=True)
class Rates:
    """The turning about one axis: the points (°/s), how many, and ω (°/s) taken for p."""

    axis: str
    points: Pair
    count: str
    largest: str


@dataclass(frozen=True)
class Conditions:
    """What the certificate says about how it was measured; has_p: whether p is calibrated."""

    rates: tuple[Rates, ...]
    has_p: bool
    fields: tuple[Field, ...]
    sentences: tuple[Pair, ...]


def conditions(calibration: Calibration, manifest: Manifest) -> Conditions:
    """Rate points, dwell, positions, mounting, and whether the largest rate was included."""
    turning = [each for each in calibration.segments if each.kind in ("rate", "rotation")]
    rates = tuple(_rates(calibration, axis) for axis in AXES) if turning else ()
    of_ahrs = calibration.method == "jjf1536"
    position = (manifest.model_extra or {}).get("mounting_position")
    return Conditions(
        rates=rates,
        has_p=not of_ahrs,
        fields=(
            Field(("采样时间（最短）", "Dwell (shortest)"), _dwell(calibration)),
            Field(("静止位置", "Positions at rest"), _positions(calibration, manifest)),
            *(ahrs_fields(calibration, manifest) if of_ahrs else ()),
            Field(
                ("安装姿态四元数（w, x, y, z）", "Mounting quaternion (w, x, y, z)"),
                _attitudes(manifest),
            ),
            Field(
                ("安装位置", "Mounting position"),
                given(str(position)) if position is not None else NOT_GIVEN,
            ),
        ),
        sentences=(_range(calibration, manifest),) if turning else (),
    )


def _rates(calibration: Calibration, axis: Axis) -> Rates:
    held = _held(calibration, axis)
    points = sorted({each.rate_deg_s for each in held if each.rate_deg_s is not None})
    turns = sum(each.kind == "rotation" and each.axis == axis for each in calibration.segments)
    written: Pair = ("—", "—")
    if points:
        written = (_signed(points),) * 2
    elif turns:
        written = (f"已知转角 {turns} 段", f"{turns} turns by a known angle")
    return Rates(
        axis=axis.upper(),
        points=written,
        count=str(len(points)),
        largest=_rate_for_p(calibration, axis),
    )


def _held(calibration: Calibration, axis: Axis) -> list[SegmentUsed]:
    return [each for each in calibration.segments if each.kind == "rate" and each.axis == axis]


def _signed(points: list[float]) -> str:
    """−5, ±10, ±20: a rate held in both directions is written once."""
    there, written = set(points), []
    for size in sorted({abs(point) for point in points}):
        both = {size, -size} <= there
        sign = "±" if both and size else "+" if size in there and size else ""
        written.append(f"{sign}{number(size)}" if both or size in there else number(-size))
    return ", ".join(written)


def _rate_for_p(calibration: Calibration, axis: Axis) -> str:
    """The largest rate about an axis that stood vertical; — where p of that axis has no value."""
    p = calibration.items.get("accel_rate_sensitivity")
    if p is None or all(v is None for element, v in p.value.items() if element[-1] == axis):
        return "—"
    held = _held(calibration, axis)
    upright = [each for each in held if (each.up or "")[1:] == axis] or held
    return number(max(abs(each.rate_deg_s or 0.0) for each in upright)) if upright else "—"


def _dwell(calibration: Calibration) -> Pair:
    """The shortest rest and the shortest held rate, rounded down so that none looks longer."""
    said = []
    for kind, zh, en in (("static", "静止", "at rest"), ("rate", "恒速转动", "at a held rate")):
        lasts = [each.t_end - each.t_start for each in calibration.segments if each.kind == kind]
        if lasts:
            seconds = math.floor(min(lasts) * 10 + 1e-6) / 10
            said.append((f"{zh} {seconds:.1f} s", f"{seconds:.1f} s {en}"))
    return given("；".join(zh for zh, _ in said), "; ".join(en for _, en in said))


def _positions(calibration: Calibration, manifest: Manifest) -> Pair:
    """How many rests, which axes were up, and at which headings as far as the labels tell."""
    turned = {each.name: each.turn_deg for each in manifest.segments or ()}
    rests = [each for each in calibration.segments if each.kind == "static"]
    seen = {(each.up, turned.get(each.name)) for each in rests if each.up}
    ups = sorted({up for up, _ in seen}, key=lambda up: (up[1:], up))
    headings = sorted({turn for _, turn in seen if turn is not None})
    if not rests:
        return NOT_GIVEN
    zh, en = f"静止 {len(rests)} 段", f"{len(rests)} rests"
    if ups:
        zh += f"；朝天轴 {len(ups)} 种：{', '.join(ups)}"
        en += f"; {len(ups)} directions up: {', '.join(ups)}"
    if headings:
        written = ", ".join(f"{number(each)}°" for each in headings)
        every = all((up, turn) in seen for up in ups for turn in headings)
        zh += f"；方位 {written}" + ("" if every else "（并非每个朝向都有）")
        en += f"; headings {written}" + ("" if every else " (not each with every axis up)")
    else:
        zh, en = f"{zh}；方位未提供", f"{en}; headings not given"
    return pair(zh, en)


def _attitudes(manifest: Manifest) -> Pair:
    """Every mounting that a segment names, that of the manifest where one names none."""
    segments = manifest.segments or ()
    mounts = [each.mount or manifest.mount for each in segments] or [manifest.mount]
    written = dict.fromkeys(
        f"({', '.join(number(part) for part in mount.quaternion_wxyz)})" for mount in mounts
    )
    return given("；".join(written), "; ".join(written))


def _range(calibration: Calibration, manifest: Manifest) -> Pair:
    """Whether each axis that was turned was turned at the unit's largest input rate."""
    told = (manifest.unit.model_extra or {}).get("rate_range_deg_s")
    if isinstance(told, bool) or not isinstance(told, int | float) or told <= 0:
        return UNTOLD_RANGE
    short = [
        axis.upper()
        for axis in AXES
        if max((abs(s.rate_deg_s or 0.0) for s in _held(calibration, axis)), default=0.0)
        < FULL_SCALE * told
    ]
    largest, axes = number(told), ", ".join(short)
    if short:
        return (
            f"被校对象的最大输入角速率为 {largest} °/s；{axes} 轴的速率点未包括该值。",
            f"The unit's largest input rate is {largest} °/s; about {axes} it was not included.",
        )
    return (
        f"被校对象的最大输入角速率为 {largest} °/s；各轴速率点均包括该值。",
        f"The unit's largest input rate is {largest} °/s; it was included about every axis.",
    )
