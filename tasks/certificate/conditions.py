"""The conditions of the measurement, as segments and manifest state them."""

import math
from dataclasses import dataclass

from schemas.calibration import Calibration, SegmentUsed
from schemas.configuration import Configuration
from schemas.recording import AXES, Axis, Manifest
from tasks.certificate.fields import NONE, NOT_GIVEN, Field, field, given
from tasks.certificate.positions import positions, turns, zero_positions
from tasks.conformity.deviations import largest_rate
from tasks.specifications.specification import Specification
from tasks.words import Message, Sayable, clauses, message, say
from tasks.words.rounding import as_given


@dataclass(frozen=True)
class Rates:
    """The turning about one axis: the points (°/s), how many, and ω (°/s) taken for p."""

    axis: str
    points: Sayable
    count: str
    largest: str


@dataclass(frozen=True)
class ReportedConditions:
    """What the certificate says about how it was measured; has_p: whether p is calibrated."""

    rates: tuple[Rates, ...]
    has_p: bool
    fields: tuple[Field, ...]
    sentences: tuple[Message, ...]


def conditions(
    calibration: Calibration,
    manifest: Manifest,
    configuration: Configuration,
    specification: Specification,
) -> ReportedConditions:
    """Rate points, dwell, positions, mounting, and the largest rate if it was included.

    If it was not, that is a deviation, which the remarks state.
    """
    turned = any(segment.kind in ("rate", "rotation") for segment in calibration.segments)
    rates = largest_rate(calibration, configuration)
    return ReportedConditions(
        rates=tuple(_rates(calibration, axis) for axis in AXES) if turned else (),
        has_p="accel_rate_sensitivity" in specification.definitions,
        fields=tuple(
            field(name, FIELDS[name](calibration, manifest))
            for name in specification.reported_conditions
        ),
        sentences=(rates.sentence,) if rates and rates.included else (),
    )


def _rates(calibration: Calibration, axis: Axis) -> Rates:
    points = sorted({s.rate_deg_s for s in _held(calibration, axis) if s.rate_deg_s is not None})
    turned = sum(s.kind == "rotation" and s.axis == axis for s in calibration.segments)
    written: Sayable = NONE
    if points:
        written = given(_signed(points))
    elif turned:
        written = message("certificate-turns.known-angle", count=turned)
    return Rates(
        axis=axis.upper(),
        points=written,
        count=str(len(points)),
        largest=_rate_for_p(calibration, axis),
    )


def _held(calibration: Calibration, axis: Axis) -> list[SegmentUsed]:
    return [s for s in calibration.segments if s.kind == "rate" and s.axis == axis]


def _signed(points: list[float]) -> str:
    """−5, ±10, ±20: a rate held in both directions is written once."""
    there, written = set(points), []
    for size in sorted({abs(point) for point in points}):
        both = {size, -size} <= there
        sign = "±" if both and size else "+" if size in there and size else ""
        positive = both or size in there
        written.append(f"{sign}{as_given(size)}" if positive else as_given(-size))
    return ", ".join(written)


def _rate_for_p(calibration: Calibration, axis: Axis) -> str:
    """The largest rate about an axis that stood vertical; — where p of that axis has no value."""
    p = calibration.items.get("accel_rate_sensitivity")
    if p is None or all(v is None for element, v in p.value.items() if element[-1] == axis):
        return say(NONE)
    held = _held(calibration, axis)
    upright = [s for s in held if (s.up or "")[1:] == axis] or held
    return as_given(max(abs(s.rate_deg_s or 0.0) for s in upright)) if upright else say(NONE)


def _dwell(calibration: Calibration, _: Manifest) -> Sayable:
    """The shortest rest and the shortest held rate, rounded down so that none looks longer."""
    parts = []
    for kind in ("static", "rate"):
        lasts = [s.t_end - s.t_start for s in calibration.segments if s.kind == kind]
        if lasts:
            seconds = math.floor(min(lasts) * 10 + 1e-6) / 10
            parts.append(message(f"certificate-dwell.{kind}", seconds=f"{seconds:.1f}"))
    return clauses(parts) if parts else NOT_GIVEN


def _attitudes(_: Calibration, manifest: Manifest) -> Sayable:
    """Every mounting that a segment names, that of the manifest where one names none."""
    segments = manifest.segments or ()
    mounts = [segment.mount or manifest.mount for segment in segments] or [manifest.mount]
    written = dict.fromkeys(
        f"({', '.join(map(as_given, mount.quaternion_wxyz))})" for mount in mounts
    )
    return clauses([given(attitude) for attitude in written])


def _mounting(_: Calibration, manifest: Manifest) -> Sayable:
    position = (manifest.model_extra or {}).get("mounting_position")
    return given(None if position is None else str(position))


FIELDS = {
    "dwell": _dwell,
    "positions": positions,
    "zero-positions": zero_positions,
    "turns": turns,
    "attitudes": _attitudes,
    "mounting": _mounting,
}
