"""The positions of the rests and the turns between them, as the labels state them."""

import math
from collections import defaultdict

from schemas.calibration import Calibration
from schemas.recording import AXES, Manifest, Segment
from tasks.certificate.fields import NOT_GIVEN
from tasks.words import Sayable, clauses, message
from tasks.words.rounding import as_given

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
            counts=counts, rates=", ".join(map(as_given, rates)),
        )  # fmt: skip
        parts.append(message("certificate-of-axis", axis=axis.upper(), text=written))
    return clauses(parts) if parts else NOT_GIVEN


def _used(calibration: Calibration, manifest: Manifest) -> list[Segment]:
    used = {segment.name for segment in calibration.segments}
    return [label for label in manifest.segments or () if label.name in used]
