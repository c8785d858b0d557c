"""Sentences of the certificate: basis, uncertainty, reasons, readings of the standard, remarks."""

import math
import re
from dataclasses import dataclass

from schemas.calibration import AdoptedTerm, Calibration, Item
from schemas.decision import Decision
from schemas.text import Remark
from tasks.certificate.cover import by_document, by_method
from tasks.certificate.equipment import axes_of_results, whose_limits
from tasks.certificate.fields import given, quoted, slug
from tasks.certificate.merged_remarks import alike
from tasks.conformity.deviations import NOT_RECORDED, Deviation
from tasks.specifications.items import item_title
from tasks.specifications.specification import Specification
from tasks.words import Message, Sayable, clauses, message, statement
from tasks.words.quantities import quantity
from tasks.words.rounding import USUAL_K
from tasks.words.typography import clause


@dataclass(frozen=True)
class RemarkRow:
    """What the reader has to know, and the segments it is about where it does not name them."""

    text: Message
    segments: str = ""


@dataclass(frozen=True)
class ReadingRow:
    """How the specification was read where it is wrong or silent: R1, the clause, the reading."""

    short: str
    clause: Sayable
    text: Sayable


def determined(item: Item | None) -> bool:
    """Whether an item has at least one value."""
    return item is not None and any(value is not None for value in item.value.values())


def basis(
    calibration: Calibration, specification: Specification, deviates: bool
) -> tuple[Message, ...]:
    """Which clauses the values follow, whether exactly, what was corrected for beforehand, and
    which items have no value; deviates: whether a condition was not shown to be met.
    """
    statements = []
    values = [item for item in calibration.items.values() if determined(item)]
    if values:
        title = message(by_document("specification", specification))
        followed = message(by_method("basis", calibration, deviates), specification=title)
        clauses = {clause(item.clause, specification.standard) for item in values}
        named = sorted((c for c in clauses if c.en), key=lambda c: (c.zh, c.en))
        if named:
            followed = message("certificate-basis.clauses", basis=followed, clauses=tuple(named))
        statements.append(message("certificate-basis.end", basis=followed))
    statements += map(_taken_off, calibration.terms)
    absent = tuple(
        item_title(name)
        for name in specification.required
        if not determined(calibration.items.get(name))
    )
    if absent:
        statements.append(message(by_document("absent", specification), items=absent))
    return tuple(statements)


def _taken_off(term: AdoptedTerm) -> Message:
    """What was corrected for: the parameters that the recording determines, with U."""
    title = quoted(term.title, term.title_zh)
    if not term.parameters:
        return message("certificate-taken-off", title=title)
    sizes = tuple(f"{p.name} = {quantity(p.value, USUAL_K * p.u, p.unit)}" for p in term.parameters)
    return message("certificate-taken-off.sizes", title=title, sizes=sizes)


def uncertainty_in_short(calibration: Calibration) -> Message | None:
    """What U contains and which coverage probability goes with k; None without a value."""
    values = [item for item in calibration.items.values() if determined(item)]
    if not values:
        return None
    kinds = dict.fromkeys(item.uncertainty_kind for item in values)
    contents = [message(f"certificate-u-in-short.{slug(kind)}") for kind in kinds]
    return message("certificate-u-in-short", parts=clauses([*contents, *_coverages(values)]))


def _coverages(values: list[Item]) -> list[Message]:
    """The coverage probability of k; by Student's t for budgets with few degrees of freedom."""
    largest = max(item.k for item in values)
    if all(item.uncertainty_kind == "Monte Carlo" for item in values):
        return [message("certificate-coverage.up-to", k=f"{largest:g}")]
    if largest > USUAL_K and all(item.uncertainty_kind == "GUM" for item in values):
        return [message("certificate-coverage.by-t", k=f"{largest:g}")]
    return [
        message("certificate-coverage", k=f"{k:g}", percent=f"{100 * math.erf(k / 2**0.5):.0f}")
        for k in dict.fromkeys(item.k for item in values)
    ]


def uncertainty(calibration: Calibration, specification: Specification) -> tuple[Message, ...]:
    """What U is, how it was rounded, and what is not in it."""
    kinds = dict.fromkeys(item.uncertainty_kind for item in calibration.items.values())
    return (
        message("certificate-rounding"),
        *(message(f"certificate-u-contains.{slug(kind)}") for kind in kinds),
        *whose_limits(calibration, specification),
        *axes_of_results(calibration, specification),
    )


def reasons(
    calibration: Calibration, decision: Decision, deviating: tuple[Deviation, ...]
) -> tuple[Message, ...]:
    """Why a unit does not pass; the remarks that stand below anyway are only counted."""
    translated = dict(zip(decision.reasons, decision.reasons_zh, strict=False))
    blocking = [remark.en for remark in calibration.remarks if remark.blocks_pass]
    open_ = [statement(each.printed).en for each in deviating if not each.waived]
    count = len(open_) + sum(group[0].blocks_pass for group in alike(calibration.remarks))
    blocking += open_
    own = [
        message("certificate-quoted", text=given(en, translated.get(en)))
        for en in decision.reasons
        if en not in blocking
    ]
    if blocking:
        own.append(message("certificate-see-remarks", count=count))
    return tuple(own)


def identifiers(calibration: Calibration) -> dict[str, str]:
    """The readings that the values rest on, in order of appearance, and their names R1, R2 …"""
    values = (item for item in calibration.items.values() if determined(item))
    every = (reading for item in values for reading in item.readings)
    return {reading: f"R{n}" for n, reading in enumerate(dict.fromkeys(every), start=1)}


def readings(calibration: Calibration) -> tuple[ReadingRow, ...]:
    """The readings taken, from the register."""
    from tasks.specifications.readings import READINGS

    rows = []
    for identifier, short in identifiers(calibration).items():
        known = READINGS.get(identifier)
        rows.append(
            ReadingRow(short, clause(known.clause), statement(known.text))
            if known
            else ReadingRow(short, given(identifier), message("certificate-unregistered"))
        )
    return tuple(rows)


def remarks(calibration: Calibration, deviating: tuple[Deviation, ...]) -> tuple[RemarkRow, ...]:
    """What the reader has to know about this calibration: deviations, then remarks with the
    segments they are about.
    """
    others = (remark for remark in calibration.remarks if remark.code not in NOT_RECORDED)
    return (*(RemarkRow(each.printed) for each in deviating), *map(_remark, alike(others)))


def _remark(group: list[Remark]) -> RemarkRow:
    """The first of remarks that say the same of several segments, with the names of the others;
    its segments where the sentence does not name them, and what it prevents.
    """
    remark, *others = group
    sentence = quoted(remark.en, remark.zh)
    named = (re.search(rf"(?<!\w){re.escape(n)}(?!\w)", remark.en) for n in remark.segments)
    names = dict.fromkeys(() if all(named) else remark.segments)
    if others:
        more = dict.fromkeys(name for other in others for name in other.segments)
        sentence = message("certificate-remark.alike", remark=sentence, count=len(more))
        names |= more
    if remark.run == "invalid":
        sentence = message("certificate-remark.invalid", remark=sentence)
    if remark.blocks_pass:
        sentence = message("certificate-remark.blocks", remark=sentence)
    return RemarkRow(sentence, ", ".join(names))
