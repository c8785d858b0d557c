"""The validation record shipped with the code, and its check before a certificate.

What makes it (`tasks.validation.make`) is not imported here: a certificate starts at once.
"""

from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from schemas.calibration import (
    EVIDENCE,
    TARGET_SHARE,
    Calibration,
    Check,
    Coverage,
    ItemValidation,
    Method,
    ValidationRecord,
)
from tasks.conformity.limits import Doubt
from tasks.rendering import draw, inline, page
from tasks.specifications.estimate import item_title
from tasks.validation.fingerprint import fingerprint, text_digest
from tasks.version import code_version
from tasks.words import Message, Sayable, clauses, message, worded

if TYPE_CHECKING:
    from matplotlib.figure import Figure


TEMPLATE = Path(__file__).parent / "templates" / "validation.html"
LOWEST = 0.88  # share that the picture shows
GOOD, BAD, ASKED_FOR = "#14691b", "#a1190d", "#dcefdc"
SHIPPED = "record.json"
G_SENSITIVITY = "gyro_g_sensitivity"
# What a result says of itself (code of a remark, setting, symbol of a line), as a condition.
CONDITIONS = {
    "table_by_labels": "labels", "coarse_step": "coarse-steps", "one_heading": "one-heading",
    "number_of_rates": "few-rates", "follows_temperature": "warming", "drift_in_run": "drift",
    "mount": "mount", "τ": "polled", "α6": "base",
}  # fmt: skip
WITHOUT_EARTH = "gyro_g_sensitivity_without_earth_rotation"


def conditions_of(calibration: Calibration) -> frozenset[str]:
    """What of a result's conditions is not as in a run in which everything is in order."""
    codes = {one.code for one in calibration.remarks} | set(calibration.settings)
    lines = (b.inputs for item in calibration.items.values() for b in item.budgets.values())
    codes |= {line.symbol for inputs in lines for line in inputs}
    return frozenset(condition for code, condition in CONDITIONS.items() if code in codes)


def scenarios_of(record: ValidationRecord, calibration: Calibration) -> list[str]:
    """The scenarios validated for the method that have all of a result's conditions."""
    own = conditions_of(calibration)
    return [
        name
        for name, scenario in record.scenarios.items()
        if calibration.method in scenario.items and own <= set(scenario.conditions)
    ]


def clause_item(name: str) -> str:
    """The item that evidence belongs to: the second value of one has its clause and its budget."""
    return G_SENSITIVITY if name == WITHOUT_EARTH else name


def checked(passed: bool, sentence: Message) -> Check:
    """A piece of evidence with what was compared."""
    return Check(**worded(sentence), passed=passed)


def shipped() -> ValidationRecord | None:
    """The record that comes with the program, None where it was taken away."""
    file = files("tasks.validation") / SHIPPED
    if not file.is_file():
        return None
    return ValidationRecord.model_validate_json(file.read_text(encoding="utf-8"))


def doubts_of(record: ValidationRecord | None, calibration: Calibration) -> dict[str, Doubt]:
    """Why items of a calibration are not validated, or elements of them; empty where all are."""
    method = record.methods.get(calibration.method) if record else None
    if record is None or method is None or not _is_of_this_code(record, calibration.method):
        stale = message("validation-stale", method=calibration.method)
        return dict.fromkeys(calibration.items, Doubt(stale))
    doubts = {}
    for name in calibration.items:
        both = name == G_SENSITIVITY and WITHOUT_EARTH in method.items
        parts = (name, WITHOUT_EARTH) if both else (name,)
        found = [method.items.get(part) for part in parts]
        failed = filter(None, (_failed(name, part) for part in found))
        if doubt := next(failed, None) or _too_short(name, found):
            doubts[name] = doubt
    return doubts


def is_current(record: ValidationRecord) -> bool:
    """Whether every method computes what it did when the record was made."""
    return all(_is_of_this_code(record, method) for method in record.methods)


def _is_of_this_code(record: ValidationRecord, method: Method) -> bool:
    return is_of_this_text(record, method) or (
        record.methods[method].fingerprint == fingerprint(method)
    )


def is_of_this_text(record: ValidationRecord, method: Method) -> bool:
    """Whether the whole program, or the method's source, is the text that the record was made of:
    then no file has to be parsed.
    """
    recorded = record.methods[method]
    made_by, runs_now = (
        version.partition(" ")[0] for version in (record.code_version, code_version())
    )
    return made_by == runs_now or (
        recorded.text != "" and recorded.text == text_digest(recorded.sources)
    )


def _failed(name: str, item: ItemValidation | None) -> Doubt | None:
    if item is not None and item.valid:
        return None
    checks = item.checks if item else {}
    open_ = [kind for kind in EVIDENCE if kind not in checks or not checks[kind].passed]
    return Doubt(message("validation-failed", item=name, evidence=", ".join(open_)))


def _too_short(name: str, parts: list[ItemValidation | None]) -> Doubt | None:
    """The elements of an item whose own intervals hold the truth too rarely.

    Where an item has two values, an element is validated if both of it are.
    """
    shares: dict[str, list[float]] = {}
    for part in parts:
        for element, share in (part.coverage.too_short if part and part.coverage else {}).items():
            shares.setdefault(element, []).append(share)
    if not shares:
        return None
    sentence = message(
        "validation-failed.element", item=item_title(name), elements=_listed(shares),
        low=f"{100 * TARGET_SHARE[0]:.0f}",
    )  # fmt: skip
    return Doubt(sentence, frozenset(shares))


def _listed(shares: dict[str, list[float]]) -> str:
    """xy (91.1 %), xz (98.9 %)"""
    percent = {
        element: ", ".join(f"{100 * share:.1f} %" for share in of_element)
        for element, of_element in shares.items()
    }
    return ", ".join(f"{element} ({share})" for element, share in percent.items())


def named(record: ValidationRecord | None, calibration: Calibration) -> Sayable:
    """The sentence of a certificate that names the record and its result."""
    doubts = doubts_of(record, calibration)
    in_part = {name: doubt.elements for name, doubt in doubts.items() if doubt.elements}
    if record is None or (len(doubts) == len(calibration.items) and not in_part):
        return message("validation-none")
    elements = tuple(
        message("validation-elements", item=item_title(name), elements=", ".join(sorted(few)))
        for name, few in in_part.items()
    )
    sentence = message(
        "validation-record.in-part" if in_part else "validation-record",
        record=f"{record.made_on} ({record.methods[calibration.method].fingerprint})",
        valid=len(calibration.items) - len(doubts), items=len(calibration.items),
        **({"elements": clauses(elements)} if in_part else {}),
    )  # fmt: skip
    return clauses((sentence, _walked(record, calibration))) if record.scenarios else sentence


def _walked(record: ValidationRecord, calibration: Calibration) -> Message:
    """In which scenarios a result's conditions lie; that they lie in none."""
    within = scenarios_of(record, calibration)
    if within:
        return message("validation-within", scenarios=_named(within))
    return message("validation-within.none", conditions=_named(sorted(conditions_of(calibration))))


def _named(scenarios: Iterable[str]) -> Sayable:
    """Scenarios, or conditions, by what people call them."""
    each = [message("validation-scenario", name=name) for name in scenarios]
    return clauses(each, "validation-within.list")


def validation_html(record: ValidationRecord) -> str:
    """The HTML of a record."""
    rows = [
        (method, name, item)
        for method, of_method in record.methods.items()
        for name, item in of_method.items.items()
    ]
    covered = [(f"{method}: {name}", item.coverage) for method, name, item in rows if item.coverage]
    return page(
        TEMPLATE,
        record=record,
        rows=rows,
        valid=sum(item.valid for _, _, item in rows),
        short=sum(len(coverage.too_short) for _, coverage in covered),
        long=sum(len(coverage.too_long) for _, coverage in covered),
        asked=[f"{100 * share:.0f}" for share in TARGET_SHARE],
        evidence=EVIDENCE,
        walked=[
            (name, method, item, coverage, scenario.invalid)
            for name, scenario in record.scenarios.items()
            for method, items in scenario.items.items()
            for item, coverage in items.items()
        ],
        picture=inline(_picture(covered)) if covered else "",
    )


def _picture(rows: list[tuple[str, Coverage]]) -> str:
    """Shares inside the 95 % interval with their own intervals, against what is asked."""

    def content(figure: "Figure") -> None:
        axes = figure.subplots()
        axes.axvspan(*TARGET_SHARE, color=ASKED_FOR)
        for place, (_, coverage) in enumerate(rows):
            inside = TARGET_SHARE[0] <= coverage.inside_95 <= TARGET_SHARE[1]
            colour = GOOD if inside else BAD
            low, high = (max(end, LOWEST) for end in coverage.confidence)
            axes.hlines(place, low, high, color=colour, linewidth=2)
            axes.plot(max(coverage.inside_95, LOWEST), place, "o", color=colour, markersize=7)
        axes.set(xlim=(LOWEST, 1.0), ylim=(len(rows) - 0.4, -0.6))
        axes.set_yticks(range(len(rows)), [name for name, _ in rows])
        axes.xaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")
        axes.tick_params(axis="y", length=0)

    return draw("Shares inside the 95 % interval", 900, 22 * len(rows) + 40, content)
