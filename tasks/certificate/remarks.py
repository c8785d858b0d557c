"""Remarks that concern the client; remarks that differ only in the segment are told once."""

import re
from collections import Counter
from collections.abc import Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass

from schemas.calibration import Calibration
from schemas.recording import Manifest
from schemas.text import Remark
from tasks.certificate.fields import quoted
from tasks.conformity.decide import NOT_RECORDED, Deviation
from tasks.words import Message, Sayable, clauses, kind_of, message, say

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
