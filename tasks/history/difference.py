"""The difference between two results of one run: values, uncertainties, verdicts."""

from collections.abc import Iterator

from schemas.base import Unusable
from schemas.calibration import Calibration, Item
from schemas.history import Change, Difference, Flip
from schemas.tolerance import Tolerance
from tasks.conformity import decide


def difference(
    before: Calibration, after: Calibration, tolerance: Tolerance | None = None
) -> Difference:
    """What changed between two results by one method; nothing for two with equal numbers.

    Verdicts on elements are by the same limits for both, and by the results alone: the effect of an
    expired standard or a missing validation on either verdict is not a difference of code. Limits
    that do not apply to such a result change nothing.
    """
    return Difference(
        changed=tuple(_changes(before, after)), flips=tuple(_flips(before, after, tolerance))
    )


def _changes(before: Calibration, after: Calibration) -> Iterator[Change]:
    for name in dict.fromkeys((*before.items, *after.items)):
        old, new = before.items.get(name), after.items.get(name)
        elements = dict.fromkeys((*(old.value if old else ()), *(new.value if new else ())))
        for element in elements:
            was, U_was = _of(old, element)
            now, U_now = _of(new, element)
            if (was, U_was) == (now, U_now):
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
            )


def _of(item: Item | None, element: str) -> tuple[float | None, float | None]:
    return (item.value.get(element), item.U.get(element)) if item else (None, None)


def _in_U(was: float | None, now: float | None, U: float | None) -> float | None:
    if was is None or now is None or not U:
        return None
    return abs(now - was) / U


def _flips(before: Calibration, after: Calibration, tolerance: Tolerance | None) -> Iterator[Flip]:
    of = {"run": after.run, "method": after.method}
    was, now = before.validity.verdict, after.validity.verdict
    if was != now:
        yield Flip(about="run", before=was, after=now, **of)
    if tolerance is None:
        return
    try:
        old, new = decide(before, tolerance), decide(after, tolerance)
    except Unusable:
        return
    if old.verdict != new.verdict:
        yield Flip(about="unit", before=old.verdict, after=new.verdict, **of)
    old_of = {(limit.item, limit.element): limit.verdict for limit in old.limits}
    for limit in new.limits:
        earlier = old_of.get((limit.item, limit.element), "inconclusive")
        if earlier != limit.verdict:
            place = {"item": limit.item, "element": limit.element}
            yield Flip(about="element", before=earlier, after=limit.verdict, **place, **of)
