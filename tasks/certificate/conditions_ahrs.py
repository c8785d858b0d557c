"""What JJF 1536-2015 adds to the conditions: the positions of 7.2 and the whole turns of 7.3."""

import math
from collections import defaultdict

from schemas.calibration import Calibration
from schemas.recording import AXES, Manifest, Segment
from tasks.certificate.fields import NOT_GIVEN, Field, number
from tasks.certificate.names import Pair
from tasks.certificate.typography import pair

NO_POSITION = ("scale_factor", "rate_sensitivity", "misalignment")


def ahrs_fields(calibration: Calibration, manifest: Manifest) -> tuple[Field, ...]:
    """How many positions for each axis and how long; how many turns each way and how fast."""
    used = {each.name for each in calibration.segments}
    labels = [each for each in manifest.segments or () if each.name in used]
    return (
        Field(("零偏位置", "Positions for the zero offset"), _positions(labels)),
        Field(("整周转动", "Whole turns"), _turns(labels)),
    )


def _positions(labels: list[Segment]) -> Pair:
    held = defaultdict(list)
    for each in labels:
        if each.kind == "static" and each.item not in NO_POSITION:
            held[each.axis or ""].append(each.t_end - each.t_start)
    said = [
        (
            f"{f'{axis.upper()} 轴 ' if axis else ''}{len(held[axis])} 个，各 {seconds} s",
            f"{f'{axis.upper()}: ' if axis else ''}{len(held[axis])} of {seconds} s each",
        )
        for axis in ("", *AXES)
        if axis in held
        for seconds in (math.floor(min(held[axis]) + 1e-6),)
    ]
    return _joined(said)


def _turns(labels: list[Segment]) -> Pair:
    said = []
    for axis in AXES:
        turns = [each for each in labels if each.kind == "rotation" and each.axis == axis]
        if not turns:
            continue
        counts = ", ".join(f"{(each.angle_deg or 0.0) / 360.0:+.4g}" for each in turns)
        rates = sorted({abs(each.rate_deg_s) for each in turns if each.rate_deg_s is not None})
        at = f" {', '.join(map(number, rates))} °/s" if rates else ""
        said.append(
            (
                f"{axis.upper()} 轴 {counts} 周" + (f"，{at.strip()}" if at else ""),
                f"{axis.upper()}: {counts} turns" + (f" at{at}" if at else ""),
            )
        )
    return _joined(said)


def _joined(said: list[Pair]) -> Pair:
    if not said:
        return NOT_GIVEN
    return pair("；".join(zh for zh, _ in said), "; ".join(en for _, en in said))
