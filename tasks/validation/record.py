"""The validation record that is shipped with the code, asked at the gate.

What makes it (`tasks.validation.make`) is not imported here: a certificate starts at once.
"""

from importlib.resources import files

from schemas.calibration import Calibration, Method
from schemas.validation import EVIDENCE, Check, ItemValidation, ValidationRecord
from tasks.validation.fingerprint import fingerprint
from tasks.version import code_version
from tasks.words import Message, message, statement

SHIPPED = "record.json"
G_SENSITIVITY = "gyro_g_sensitivity"
WITHOUT_EARTH = "gyro_g_sensitivity_without_earth_rotation"


def clause_item(name: str) -> str:
    """The item that evidence belongs to: the second value of one has its clause and its budget."""
    return G_SENSITIVITY if name == WITHOUT_EARTH else name


def checked(passed: bool, sentence: Message) -> Check:
    """A piece of evidence with what was compared."""
    stated = statement(sentence)
    return Check(passed=passed, en=stated.en, zh=stated.zh)


def shipped() -> ValidationRecord | None:
    """The record that comes with the program, None where it was taken away."""
    file = files("tasks.validation") / SHIPPED
    if not file.is_file():
        return None
    return ValidationRecord.model_validate_json(file.read_text(encoding="utf-8"))


def doubts_of(record: ValidationRecord | None, calibration: Calibration) -> dict[str, Message]:
    """Why items of a calibration are not validated, by item; empty where all of them are."""
    method = record.methods.get(calibration.method) if record else None
    if record is None or method is None or not _is_of_this_code(record, calibration.method):
        stale = message("validation-stale", method=calibration.method)
        return dict.fromkeys(calibration.items, stale)
    doubts = {}
    for name in calibration.items:
        both = name == G_SENSITIVITY and WITHOUT_EARTH in method.items
        parts = (name, WITHOUT_EARTH) if both else (name,)
        failed = filter(None, (_failed(name, method.items.get(part)) for part in parts))
        if reason := next(failed, None):
            doubts[name] = reason
    return doubts


def is_current(record: ValidationRecord) -> bool:
    """Whether every method computes what it did when the record was made."""
    return all(_is_of_this_code(record, method) for method in record.methods)


def _is_of_this_code(record: ValidationRecord, method: Method) -> bool:
    """Whether what a method computes is what it was when the record was made.

    No file has to be parsed where the whole program is still the same text.
    """
    made_by, runs_now = (
        version.partition(" ")[0] for version in (record.code_version, code_version())
    )
    return made_by == runs_now or record.methods[method].fingerprint == fingerprint(method)


def _failed(name: str, item: ItemValidation | None) -> Message | None:
    if item is not None and item.valid:
        return None
    checks = item.checks if item else {}
    open_ = [kind for kind in EVIDENCE if kind not in checks or not checks[kind].passed]
    return message("validation-failed", item=name, evidence=", ".join(open_))


def named(record: ValidationRecord | None, calibration: Calibration) -> Message:
    """The sentence of a certificate that names the record and its result."""
    doubts = doubts_of(record, calibration)
    if record is None or len(doubts) == len(calibration.items):
        return message("validation-none")
    return message(
        "validation-record", record=f"{record.made_on}, {record.code_version.split()[0]}",
        valid=len(calibration.items) - len(doubts), items=len(calibration.items),
    )  # fmt: skip
