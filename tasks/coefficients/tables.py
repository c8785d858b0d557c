"""A correction as text for other software: YAML, ROS 2 parameters, CSV."""

import csv
import io
from typing import Any

from schemas.correction import Correction
from schemas.recording import AXES

WIDTH = 100  # characters of a line of YAML


def as_json(correction: Correction) -> str:
    """The document itself."""
    return correction.model_dump_json(indent=1) + "\n"


def as_yaml(correction: Correction) -> str:
    """The document in YAML."""
    return dump_yaml(correction.model_dump(mode="json"))


def as_ros(correction: Correction) -> str:
    """A parameter file of ROS 2, for whatever node corrects.

    Its parameters are lists of one type, so matrices stand row by row; the wildcard gives them to
    every node. Source: docs.ros.org, migrating parameters.
    """
    flat = {name: _flat(coefficient.value) for name, coefficient in correction.coefficients.items()}
    parameters = {"imu_correction": flat | {"formulas": list(correction.correction)}}
    return heading(correction, "# ") + dump_yaml({"/**": {"ros__parameters": parameters}})


def as_csv(correction: Correction) -> str:
    """A row for each element: coefficient, reading axis, input axis, value, U, unit."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("coefficient", "reads", "input", "value", "U", "unit"))
    for name, coefficient in correction.coefficients.items():
        values = _flat(coefficient.value)
        expanded = _flat(coefficient.U) if coefficient.U else [None] * len(values)
        for n, (value, U) in enumerate(zip(values, expanded, strict=True)):
            axes = (AXES[n], "") if len(values) == len(AXES) else (AXES[n // 3], AXES[n % 3])
            shown = "" if U is None else repr(U)
            writer.writerow((name, *axes, repr(value), shown, coefficient.unit))
    return text.getvalue()


def heading(correction: Correction, mark: str) -> str:
    """The unit, the omissions and the formulas of a correction, as lines of comment."""
    unit = correction.unit
    lines = [
        f"unit: {unit.manufacturer} {unit.model} {unit.serial}" if unit else "unit: unknown",
        f"recording: {correction.recording_id} (run {correction.run}), method {correction.method}",
        "model:",
        *(f"  {formula}" for formula in correction.model),
        "correction, in this order (rad/s, m/s2):",
        *(f"  {formula}" for formula in correction.correction),
    ]
    if correction.assumed_ideal:
        lines.append(f"taken as ideal, not calibrated: {', '.join(correction.assumed_ideal)}")
    if correction.left_in:
        lines.append(f"not corrected: {', '.join(correction.left_in)}")
    return "".join(f"{mark}{' '.join(line.split()) if n < 2 else line}\n"
                   for n, line in enumerate(lines))  # fmt: skip


def dump_yaml(document: Any) -> str:
    """A document as YAML, lists of numbers on one line."""
    import yaml

    return str(
        yaml.safe_dump(
            document, sort_keys=False, default_flow_style=None, allow_unicode=True, width=WIDTH
        )
    )


def _flat(values: Any) -> list[Any]:
    """The elements of a vector, or of a matrix row by row."""
    return [each for row in values for each in (row if isinstance(row, tuple) else (row,))]
