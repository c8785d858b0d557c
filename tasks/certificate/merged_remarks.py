"""Merges remarks that differ only in the segment they are about."""

import re
from collections.abc import Iterable

from schemas.text import Remark

NUMBER = re.compile(r"[+−-]?\d+(?:\.\d+)?(?:[eE][+−-]?\d+)?")
AXIS = re.compile(r"(?<![A-Za-z])[+−-]?[XYZxyz](?![A-Za-z])")


def alike(remarks: Iterable[Remark]) -> list[list[Remark]]:
    """Remarks in order; together those that differ in segment, axis and figures alone."""
    groups: dict[tuple[object, ...], list[Remark]] = {}
    for number, remark in enumerate(remarks):
        key = (remark.code, remark.blocks_pass, remark.run, _wording(remark))
        groups.setdefault(key if remark.segments else (number,), []).append(remark)
    return list(groups.values())


def _wording(remark: Remark) -> str:
    text = remark.en
    for name in sorted(remark.segments, key=len, reverse=True):
        text = re.sub(rf"(?<!\w){re.escape(name)}(?!\w)", "segment", text)
    return NUMBER.sub("#", AXIS.sub("axis", text))
