"""The conditions of the measurement, as segments and manifest state them."""

import math
from collections import defaultdict
from dataclasses import dataclass

from schemas.calibration import Calibration, SegmentUsed
from schemas.recording import AXES, Axis, Manifest, Segment
from schemas.station import Configuration
from tasks.certificate.fields import NONE, NOT_GIVEN, Field, field, given
from tasks.conformity.decide import largest_rate
from tasks.specifications.estimate import Specification
from tasks.words import Message, Sayable, clauses, message, say
from tasks.words.numbers import as_given

# The positions of the rests and the turns between them, as the labels state them.

NO_ZERO_POSITION = ("scale_factor", "rate_sensitivity", "misalignment")


def positions(calibration: Calibration, manifest: Manifest) -> Sayable:
    """How many rests, which axes were up, and at which headings as far as the labels state."""
    turned = {segment.name: segment.turn_deg for segment in manifest.segments or ()}
    rests = [segment for segment in calibration.segments if segment.kind == "static"]
    held = {(rest.up, turned.get(rest.name)) for rest in rests if rest.up}
    ups = sorted({up for up, _ in held}, key=lambda up: (up[1:], up))
    headings = sorted({turn for _, turn in held if turn is not None})
    if not rests:
        return NOT_GIVEN
    parts = [message("certificate-positions.rests", count=len(rests))]
    if ups:
        parts.append(message("certificate-positions.up", count=len(ups), ups=", ".join(ups)))
    written = ", ".join(f"{as_given(heading)}°" for heading in headings)
    every = all((up, turn) in held for up in ups for turn in headings)
    known = "not-given" if not headings else "headings" if every else "some-headings"
    parts.append(message(f"certificate-positions.{known}", headings=written))
    return clauses(parts)


def zero_positions(calibration: Calibration, manifest: Manifest) -> Sayable:
    """How many positions for the zero offset of each axis, and how long (JJF 1536, 7.2)."""
    held = defaultdict(list)
    for label in _used(calibration, manifest):
        if label.kind == "static" and label.item not in NO_ZERO_POSITION:
            held[label.axis or ""].append(label.t_end - label.t_start)
    parts = []
    for axis in ("", *AXES):
        if axis in held:
            seconds = str(math.floor(min(held[axis]) + 1e-6))
            count = message("certificate-positions.zero", count=len(held[axis]), seconds=seconds)
            of_axis = message("certificate-of-axis", axis=axis.upper(), text=count)
            parts.append(of_axis if axis else count)
    return clauses(parts) if parts else NOT_GIVEN


def turns(calibration: Calibration, manifest: Manifest) -> Sayable:
    """How many turns each way about each axis, and how fast (JJF 1536, 7.3)."""
    labels, parts = _used(calibration, manifest), []
    for axis in AXES:
        turned = [s for s in labels if s.kind == "rotation" and s.axis == axis]
        if not turned:
            continue
        counts = ", ".join(f"{(s.angle_deg or 0.0) / 360.0:+.4g}" for s in turned)
        rates = sorted({abs(s.rate_deg_s) for s in turned if s.rate_deg_s is not None})
        written = message(
            f"certificate-turns.{'at-rates' if rates else 'counts'}",
            counts=counts,
            rates=", ".join(map(as_given, rates)),
        )
        parts.append(message("certificate-of-axis", axis=axis.upper(), text=written))
    return clauses(parts) if parts else NOT_GIVEN


def _used(calibration: Calibration, manifest: Manifest) -> list[Segment]:
    used = {segment.name for segment in calibration.segments}
    return [label for label in manifest.segments or () if label.name in used]


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
