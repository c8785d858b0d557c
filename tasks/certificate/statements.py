"""Sentences of the certificate and of its annex: basis, uncertainty, reasons, readings."""

import math
import re
from collections import Counter, defaultdict
from collections.abc import Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass

from schemas.calibration import AdoptedTerm, Calibration, Item
from schemas.recording import Manifest
from schemas.text import CONTRACTED, Remark, Statement, text_of, texts_of
from schemas.tolerance import Decision, GlobalRisks, LimitDecision
from tasks.certificate import cover
from tasks.certificate.cover import by_document, by_method
from tasks.certificate.equipment import axes_of_results, flatness, whose_limits
from tasks.certificate.fields import Field, field, given, quoted, slug
from tasks.conformity.decide import NOT_RECORDED, Deviation
from tasks.conformity.limits import nothing_accepted, probability_text
from tasks.specifications.estimate import Specification, item_title, symbol
from tasks.words import Message, Sayable, argument, clauses, kind_of, message, say, statement
from tasks.words.numbers import USUAL_K, clause, exact, quantity, quantity_text, text

# Remarks that concern the client; remarks that differ only in the segment are told once.


FEW = 3  # segments that are named where the remark stands
# Stated under the item that it is about, with its size.
STATED_AT_ITEM = {"earth_rotation"}


@dataclass(frozen=True)
class RemarkRow:
    """What the reader has to know; segments: those it is about, where they are too many to name."""

    text: Message
    segments: str = ""


def remarks(
    calibration: Calibration, manifest: Manifest, deviating: tuple[Deviation, ...]
) -> tuple[RemarkRow, ...]:
    """What the reader has to know about this calibration: deviations, then remarks."""
    elsewhere = NOT_RECORDED | STATED_AT_ITEM
    others = (remark for remark in calibration.remarks if remark.code not in elsewhere)
    kinds = {segment.name: segment.kind for segment in manifest.segments or ()}
    printed = (_remark(group, kinds) for group in alike(others))
    return (*(RemarkRow(each.printed) for each in deviating), *printed)


def alike(remarks: Iterable[Remark]) -> list[list[Remark]]:
    """Remarks in order; together those that differ in segment, axis and figures alone."""
    groups: dict[Hashable, list[Remark]] = {}
    for number, remark in enumerate(remarks):
        key = (remark.code, remark.blocks_pass, remark.run, kind_of(remark))
        groups.setdefault(key if remark.segments else number, []).append(remark)
    return list(groups.values())


def once_for_all(remarks: Iterable[Remark]) -> Iterator[tuple[Remark, Sayable]]:
    """Remarks in order with their sentences; of those that hold for many segments the first, with
    how many segments more there are.
    """
    for group in alike(remarks):
        if len(group) <= FEW:
            yield from ((remark, remark) for remark in group)
            continue
        more = {name for other in group[1:] for name in other.segments}
        yield group[0], message("certificate-remark.alike", remark=group[0], count=len(more))


def _remark(group: list[Remark], kinds: Mapping[str, str]) -> RemarkRow:
    """The first of remarks that say the same of several segments; the segments that the sentence
    does not name, by name or by how many there are of each kind; what it prevents.
    """
    remark, *others = group
    sentence = quoted(remark)
    named = (re.search(rf"(?<!\w){re.escape(n)}(?!\w)", say(remark)) for n in remark.segments)
    names = dict.fromkeys(() if all(named) else remark.segments)
    if others:
        more = dict.fromkeys(name for other in others for name in other.segments)
        sentence = message("certificate-remark.alike", remark=sentence, count=len(more))
        names |= more
    listed = ", ".join(names)
    shown: Sayable = listed if len(names) <= FEW else _by_kind(names, kinds)
    if shown:
        sentence = message("certificate-remark", remark=sentence, segments=shown)
    if remark.run == "invalid":
        sentence = message("certificate-remark.invalid", remark=sentence)
    if remark.blocks_pass:
        sentence = message("certificate-remark.blocks", remark=sentence)
    return RemarkRow(sentence, listed if len(names) > FEW else "")


def _by_kind(names: Iterable[str], kinds: Mapping[str, str]) -> Sayable:
    """How many of the segments there are of each kind; nothing where no kind is known."""
    counts = Counter(kinds[name] for name in names if name in kinds)
    parts = [message(f"certificate-segments.{kind}", count=n) for kind, n in counts.items()]
    return clauses(parts) if parts else ""


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


# The statement of conformity: limits, decision rules, risks of a wrong decision, verdict.


def conformity(decision: Decision) -> tuple[Field, ...]:
    """The fields of the statement; rule and risks only where something is limited."""
    return (
        field("limits-from", given(decision.document)),
        *_rules(decision),
        *_specific_risks(decision),
        *_global_risks(decision),
        field("marks", _marks(decision)),
        field("verdict", cover.verdict(decision)),
    )


def _rules(decision: Decision) -> list[Field]:
    """Each rule in words; the items that it is for where there are several."""
    limits: dict[Message, list[LimitDecision]] = {}
    for limit in decision.limits:
        limits.setdefault(_rule(limit), []).append(limit)
    if len(limits) == 1:
        ((rule, under),) = limits.items()
        return [field("rule", _with_figures(rule, under))]
    fields = []
    for number, (rule, under) in enumerate(limits.items(), start=1):
        items = tuple(map(item_title, dict.fromkeys(limit.item for limit in under)))
        of_items = message("certificate-rule-of", items=items, rule=_with_figures(rule, under))
        fields.append(Field(message("certificate-field.rule-number", number=number), of_items))
    return fields


def _rule(limit: LimitDecision) -> Message:
    """The rule of one limit: its guard band, and what it asks of U."""
    factor = abs(limit.guard_band_factor)
    side = "-outwards" if limit.rule == "guard_band" and limit.guard_band_factor < 0 else ""
    w = "U" if factor == 1 else f"{factor:g} U"
    rule = message(f"certificate-rule.{slug(limit.rule)}{side}", w=w)
    one_sided = None in (limit.lower, limit.upper)
    if limit.min_capability is not None and not one_sided:
        needed = max(limit.min_capability, limit.guard_band_factor)
        rule = message("certificate-rule.capability", rule=rule, needed=f"{needed:g}")
    if one_sided and limit.guard_band_factor <= 0 and limit.U_max is None:
        rule = message("certificate-rule.unbounded", rule=rule)
    return rule


def _with_figures(rule: Sayable, under: list[LimitDecision]) -> Sayable:
    """The rule with the bounds on U that were agreed and the coverage factors of U."""
    parts: list[Sayable] = [rule]
    for item, largest, unit in dict.fromkeys((m.item, exact(m.U_max), m.unit) for m in under):
        if largest is not None:
            U_max = quantity_text(str(text(largest)), unit)
            parts.append(message("certificate-rule.bound", item=item_title(item), U_max=U_max))
    factors = sorted({limit.k for limit in under if limit.k is not None})
    if factors:
        k = " … ".join(f"{k:g}" for k in dict.fromkeys((factors[0], factors[-1])))
        parts.append(message("certificate-rule.coverage-factor", k=k))
    return clauses(parts)


def _specific_risks(decision: Decision) -> list[Field]:
    """The largest risk of the passes and of the fails, and whose it is."""
    parts = []
    for kind in ("acceptance", "rejection"):
        risks = [
            (risk, limit)
            for limit in decision.limits
            if (risk := getattr(limit, f"false_{kind}")) is not None
        ]
        if risks:
            risk, limit = max(risks, key=lambda pair: pair[0])
            chance, whose = probability_text(risk), symbol(limit.item, limit.element)
            parts.append(message(f"certificate-risk.{kind}", chance=chance, symbol=whose))
    return [field("risk", message("certificate-risk", parts=clauses(parts)))] if parts else []


def _global_risks(decision: Decision) -> list[Field]:
    """Risks over the production, for the worst element of each item that has a prior."""
    risks: dict[str, list[GlobalRisks]] = {}
    for limit in decision.limits:
        if limit.global_risks:
            risks.setdefault(limit.item, []).append(limit.global_risks)
    parts = [
        message(
            "certificate-global-risk.item",
            item=item_title(item),
            consumer=probability_text(max(risk.consumer for risk in of_item)),
            producer=probability_text(max(risk.producer for risk in of_item)),
        )
        for item, of_item in risks.items()
    ]
    if not parts:
        return []
    return [field("global-risk", message("certificate-global-risk", parts=clauses(parts)))]


def _marks(decision: Decision) -> Sayable:
    parts = [message("certificate-marks.absent")]
    if any(limit.probability_of_conformity is not None for limit in decision.limits):
        parts.append(message("certificate-marks.chance"))
    if any(limit.marginal for limit in decision.limits):
        parts.append(message("certificate-marks.conditional"))
    if any(map(nothing_accepted, decision.limits)):
        parts.append(message("certificate-marks.nothing-accepted"))
    return clauses(parts)
