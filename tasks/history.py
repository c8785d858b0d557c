"""Differences between an earlier result and today's, and the report of a re-processing."""

import csv
from collections.abc import Iterator, Sequence
from io import StringIO
from typing import TYPE_CHECKING, Any

from schemas.base import Unusable
from schemas.calibration import Calibration, Item
from schemas.certificate import Laboratory
from schemas.history import COUNTED_IN_U, Change, Difference, Flip, Reprocessing
from schemas.tolerance import Decision, Tolerance
from tasks.conformity import as_stated, decide
from tasks.rendering import AFTER, BEFORE, GREY, PALE, draw, picture_file
from tasks.specifications.estimate import item_title
from tasks.words import LANGUAGES, message, say

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, FRAME, ROW = 900, 110, 30  # px
LEAST, MOST = 1e-6, 100.0  # U: what is beyond stands at the edge
SPREAD = 0.6  # of a row, over which the runs of an item lie
GOLDEN = 0.618034  # of the spread, from one mark to the next: no two are near


def difference(
    before: Calibration,
    after: Calibration,
    tolerance: Tolerance | None = None,
    laboratory: Laboratory | None = None,
    printed: Decision | None = None,
) -> Difference:
    """What changed between two results by one method; nothing for two whose numbers agree.

    Verdicts on elements are by the same limits for both, and by the results alone: the effect of an
    expired standard or a missing validation on either verdict is not a difference of code. Limits
    that do not apply to such a result change nothing. laboratory: no U below its capabilities is
    decided on. printed: what a certificate of the result before says of the unit; what else
    than the result kept it from a pass still does.
    """
    old, new = as_stated(before, laboratory), as_stated(after, laboratory)
    return Difference(
        changed=tuple(_changes(before, after)), flips=tuple(_flips(old, new, tolerance, printed))
    )


def _changes(before: Calibration, after: Calibration) -> Iterator[Change]:
    for name in dict.fromkeys((*before.items, *after.items)):
        old, new = before.items.get(name), after.items.get(name)
        elements = dict.fromkeys((*(old.value if old else ()), *(new.value if new else ())))
        for element in elements:
            was, U_was = _of(old, element)
            now, U_now = _of(new, element)
            k_was, k_now = (each.k if each else None for each in (old, new))
            moved = _moved(was, now, U_was or U_now) or _moved(U_was, U_now, U_was)
            if not (moved or (was is not None and now is not None and k_was != k_now)):
                continue
            yield Change(
                run=after.run,
                method=after.method,
                item=name,
                element=element,
                unit=(new or before.items[name]).unit,
                before=was,
                after=now,
                U_before=U_was,
                U_after=U_now,
                in_U=_in_U(was, now, U_was or U_now),
                k_before=k_was,
                k_after=k_now,
            )


def _of(item: Item | None, element: str) -> tuple[float | None, float | None]:
    return (item.value.get(element), item.U.get(element)) if item else (None, None)


def _moved(was: float | None, now: float | None, scale: float | None) -> bool:
    """Whether a figure is another one by more than COUNTED_IN_U of a scale; without one, at all."""
    if was is None or now is None or not scale:
        return was != now
    return abs(now - was) > COUNTED_IN_U * scale


def _in_U(was: float | None, now: float | None, U: float | None) -> float | None:
    if was is None or now is None or not U:
        return None
    return abs(now - was) / U


def _flips(
    before: Calibration,
    after: Calibration,
    tolerance: Tolerance | None,
    printed: Decision | None = None,
) -> Iterator[Flip]:
    of = {"run": after.run, "method": after.method}
    was, now = before.validity.verdict, after.validity.verdict
    if was != now:
        yield Flip(about="run", before=was, after=now, **of)
    why, why_now = ("; ".join(each.validity.reasons) for each in (before, after))
    if was == now and why != why_now:
        yield Flip(about="reasons", before=why, after=why_now, **of)
    if tolerance is None:
        return
    try:
        alone, new = decide(before, tolerance), decide(after, tolerance)
    except Unusable:
        return
    old, verdict = printed or alone, new.verdict
    if verdict == "pass" and old.verdict == "inconclusive" != alone.verdict:
        verdict = "inconclusive"
    if old.verdict != verdict:
        yield Flip(about="unit", before=old.verdict, after=verdict, **of)
    old_of = {(limit.item, limit.element): limit.verdict for limit in old.limits}
    for limit in new.limits:
        earlier = old_of.get((limit.item, limit.element), "inconclusive")
        if earlier != limit.verdict:
            place = {"item": limit.item, "element": limit.element}
            yield Flip(about="element", before=earlier, after=limit.verdict, **place, **of)


def report_texts(report: Reprocessing) -> dict[str, str]:
    """The files of the report by name: report.json, changed.csv, and changed.svg by language."""
    return {
        "report.json": report.model_dump_json(indent=1) + "\n",
        "changed.csv": _table(report.changed),
        **{picture_file("changed", each): changed_svg(report, each) for each in LANGUAGES},
    }


def _table(changed: tuple[Change, ...]) -> str:
    text = StringIO()
    rows = csv.DictWriter(text, list(Change.model_fields), lineterminator="\n")
    rows.writeheader()
    rows.writerows(change.model_dump() for change in changed)
    return text.getvalue()


def changed_svg(report: Reprocessing, language: str) -> str:
    """The picture: a row for each item, a mark for each element of each run that moved."""
    items = list(dict.fromkeys(change.item for change in report.changed))
    figures: dict[str, Any] = {
        "done": report.done, "unchanged": report.unchanged, "least": f"{report.counted_in_U:g}",
    }  # fmt: skip
    title, change, in_part, nothing = (
        say(message(f"changed-{id_}", **figures), language)
        for id_ in ("title", "in-U", "in-part", "nothing")
    )

    def content(figure: "Figure") -> None:
        axes: Any = figure.add_subplot()
        axes.set_title(title)
        axes.set(xscale="log", xlim=(LEAST, MOST), ylim=(max(len(items), 1), 0))
        axes.set_xlabel(change, loc="right")
        axes.set_yticks(
            [row + 0.5 for row in range(len(items))],
            [say(item_title(item), language) for item in items],
        )
        axes.axvline(1.0, color=BEFORE, linewidth=1.0)
        for row, item in enumerate(items):
            axes.axhline(row + 0.5, color=PALE, linewidth=1.0, zorder=0)
            _row(axes, row + 0.5, [c for c in report.changed if c.item == item])
        if any(map(appeared_or_disappeared, report.changed)):
            axes.set_xlabel(in_part, loc="right")
        if not items:
            axes.text(0.5, 0.5, nothing, transform=axes.transAxes, ha="center", color=GREY)

    return draw(title, WIDTH, FRAME + ROW * max(len(items), 2), content)


def appeared_or_disappeared(change: Change) -> bool:
    """Whether an element was determined before and is not now, or the other way round."""
    return (change.before is None) != (change.after is None)


def _row(axes: Any, y: float, changes: Sequence[Change]) -> None:
    """The marks of an item, spread about y so that equal steps lie beside each other."""
    heights = [y + SPREAD * (GOLDEN * k % 1.0 - 0.5) for k in range(len(changes))]
    x = [min(max(c.in_U or LEAST, LEAST), MOST) for c in changes]
    for one in (True, False):  # these have no step
        shown = [k for k, c in enumerate(changes) if appeared_or_disappeared(c) is one]
        at = [MOST if one else x[k] for k in shown]
        colours = [BEFORE if step > 1.0 else AFTER for step in at]
        form = (
            {"marker": "x", "s": 25.0, "clip_on": False} if one else {"s": 9.0, "linewidths": 0.0}
        )
        axes.scatter(at, [heights[k] for k in shown], c=colours, **form)
