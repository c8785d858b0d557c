"""The validation record that is shipped with the code, asked at the gate.

What makes it (`tasks.validation.make`) is not imported here: a certificate starts at once.
"""

from importlib.resources import files

from schemas.calibration import Calibration
from schemas.validation import EVIDENCE, ItemValidation, MethodValidation, ValidationRecord
from tasks.validation.fingerprint import fingerprint

SHIPPED = "record.json"
WITH_EARTH = "gyro_g_sensitivity"
STILL = "gyro_g_sensitivity_without_earth_rotation"
Reason = tuple[str, str]
WAY_OUT = ("run mimucal validate", "请运行 mimucal validate")


def shipped() -> ValidationRecord | None:
    """The record that comes with the program, None where it was taken away."""
    file = files("tasks.validation") / SHIPPED
    if not file.is_file():
        return None
    return ValidationRecord.model_validate_json(file.read_text(encoding="utf-8"))


def doubts_of(record: ValidationRecord | None, calibration: Calibration) -> dict[str, Reason]:
    """Why items of a calibration are not validated, by item; empty where all of them are."""
    method = record.methods.get(calibration.method) if record else None
    found = {}
    for name in calibration.items:
        reason = _stale(method, calibration.method)
        if reason is None and method is not None:
            parts = (name, STILL) if name == WITH_EARTH else (name,)
            held = [
                method.items.get(part) for part in parts if part == name or part in method.items
            ]
            reason = next(filter(None, (_failed(name, item) for item in held)), None)
        if reason is not None:
            found[name] = reason
    return found


def _stale(method: MethodValidation | None, name: str) -> Reason | None:
    if method is not None and method.fingerprint == fingerprint(name):
        return None
    return (
        f"The estimation by the method {name} is not validated for this version: {WAY_OUT[0]}",
        f"本版本的 {name} 估计方法未经验证：{WAY_OUT[1]}",
    )


def _failed(name: str, item: ItemValidation | None) -> Reason | None:
    if item is not None and item.valid:
        return None
    checks = item.checks if item else {}
    open_ = [kind for kind in EVIDENCE if kind not in checks or not checks[kind].passed]
    listed = ", ".join(open_)
    return (
        f"The estimation of {name} is not validated for this version ({listed} not shown): see "
        "mimucal validate",
        f"本版本的 {name} 估计未经验证（{listed} 未通过）：见 mimucal validate",
    )


def named(record: ValidationRecord | None, calibration: Calibration) -> Reason:
    """The sentence of a certificate that names the record and its result."""
    doubts = doubts_of(record, calibration)
    if record is None or len(doubts) == len(calibration.items):
        return (
            "No validation record of this version covers the estimation",
            "无适用于本版本的估计验证记录",
        )
    valid = len(calibration.items) - len(doubts)
    which = f"{record.made_on}, {record.code_version.split()[0]}"
    return (
        f"Estimation validated by the record of {which}: {valid} of {len(calibration.items)} items",
        f"估计方法经验证，记录 {which}：{len(calibration.items)} 项中 {valid} 项通过",
    )
