"""Sentences of the certificate and of its annex: basis, uncertainty, reasons, readings."""

import math
from collections import defaultdict
from collections.abc import Hashable, Iterator
from dataclasses import dataclass

from schemas.calibration import AdoptedTerm, Calibration, Item
from schemas.decision import Decision
from schemas.text import CONTRACTED, Statement, text_of, texts_of
from tasks.certificate.cover import by_document, by_method
from tasks.certificate.equipment import axes_of_results, flatness, whose_limits
from tasks.certificate.fields import given, quoted, slug
from tasks.certificate.remarks import alike
from tasks.conformity.deviations import Deviation
from tasks.specifications.items import item_title
from tasks.specifications.specification import Specification
from tasks.words import Message, Sayable, argument, clauses, kind_of, message, say, statement
from tasks.words.quantities import quantity
from tasks.words.rounding import USUAL_K
from tasks.words.typography import clause

SYMBOL = "symbol"  # the argument of a reason by which it is of one element


@dataclass(frozen=True)
class ReadingRow:
    """How the specification was read where it is wrong or silent: R1, the clause, the items whose
    values rest on it, the reading.
    """

    short: str
    clause: Sayable
    items: Message
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
        named = sorted(filter(say, clauses), key=lambda each: each.words[CONTRACTED[-1]])
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
    title = quoted(text_of(term, "title") or statement(term.name))
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
    """The coverage probability of k, which is larger for budgets with few degrees of freedom."""
    largest = max(item.k for item in values)
    if all(item.uncertainty_kind == "Monte Carlo" for item in values):
        return [message("certificate-coverage.up-to", k=f"{largest:g}")]
    if largest > USUAL_K and all(item.uncertainty_kind == "GUM" for item in values):
        return [message("certificate-coverage.by-t", k=f"{largest:g}")]
    return [
        message("certificate-coverage", k=f"{k:g}", percent=f"{100 * math.erf(k / 2**0.5):.0f}")
        for k in dict.fromkeys(item.k for item in values)
    ]


def uncertainty(calibration: Calibration) -> tuple[Message, ...]:
    """What the client has to know of U: for which axes the results hold, what is not in it."""
    kinds = {item.uncertainty_kind for item in calibration.items.values()}
    incomplete = (message("certificate-u-contains.type-a"),) if "type A" in kinds else ()
    return (*incomplete, axes_of_results(calibration))


ZEROS = {"gyro_bias", "gyro_fit_offset", "accel_bias", "ahrs_zero_offset"}


def evaluation(
    calibration: Calibration, decision: Decision, specification: Specification
) -> Iterator[Message]:
    """How U was evaluated and rounded, on which limits it rests, how risks were calculated."""
    kinds = dict.fromkeys(item.uncertainty_kind for item in calibration.items.values())
    yield message("certificate-rounding")
    for kind in kinds:
        if kind != "type A":
            yield message(f"certificate-u-contains.{slug(kind)}")
    if any(item.k > USUAL_K for item in calibration.items.values()):
        yield message("certificate-coverage-by-t")
    yield from whose_limits(calibration)
    yield from flatness(calibration, specification)
    if ZEROS & calibration.items.keys():
        yield message("certificate-switch-on")
    if any(limit.probability_of_conformity is not None for limit in decision.limits):
        yield message("certificate-risk-how")


def reasons(
    calibration: Calibration, decision: Decision, deviating: tuple[Deviation, ...]
) -> tuple[Message, ...]:
    """Why a unit does not pass, what is alike of several elements once; the remarks that stand
    below anyway are only counted.
    """
    blocking = [say(remark) for remark in calibration.remarks if remark.blocks_pass]
    open_ = [say(each.printed) for each in deviating if not each.waived]
    count = len(open_) + sum(group[0].blocks_pass for group in alike(calibration.remarks))
    blocking += open_
    groups = defaultdict[Hashable, list[Statement]](list)
    for reason in texts_of(decision, "reasons"):
        if say(reason) not in blocking:
            one_by_one = argument(reason, SYMBOL) is None
            groups[reason if one_by_one else kind_of(reason)].append(reason)
    own = [_reason(*group) for group in groups.values()]
    if blocking:
        own.append(message("certificate-see-remarks", count=count))
    return tuple(own)


def _reason(first: Statement, *others: Statement) -> Message:
    """The first of reasons that differ in symbol and figures alone, and the others' symbols."""
    if not others:
        return quoted(first)
    symbols = ", ".join(str(argument(each, SYMBOL)) for each in others)
    return message("certificate-reason-alike", reason=quoted(first), symbols=symbols)


def readings(calibration: Calibration) -> tuple[ReadingRow, ...]:
    """The readings that the values rest on, from the register, in order of appearance."""
    from tasks.specifications.readings import READINGS

    taken = defaultdict[str, list[Sayable]](list)
    for name, item in calibration.items.items():
        if determined(item):
            for identifier in item.readings:
                taken[identifier].append(item_title(name))
    rows = []
    for number, (identifier, items) in enumerate(taken.items(), start=1):
        known = READINGS.get(identifier)
        at = clause(known.clause) if known else given(identifier)
        text = statement(known.text) if known else message("certificate-unregistered")
        rows.append(
            ReadingRow(
                f"R{number}", at, message("certificate-reading-of", items=tuple(items)), text
            )
        )
    return tuple(rows)
