"""What leaving the physics out does to the certificate: each item before and after."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.discrepancy import Consequence, VerdictChange
from schemas.recording import ANGLE, Recording, Stream
from schemas.tolerance import Decision, Tolerance
from tasks import conformity
from tasks.calibrate.calibrate import calibrate
from tasks.explain.channels import CHANNELS
from tasks.explain.explanation import Explanation
from tasks.specifications.items import ITEMS
from tasks.specifications.register import specification_for
from tasks.words import Sayable, clauses, message
from tasks.words.rounding import column
from tasks.words.units import unit_text

NOTICEABLE = 0.05  # of U: what moves an element by less is not listed
SEVERITY = ("pass", "inconclusive", "fail")
OVERALL = "certificate"


@dataclass(frozen=True)
class Consequences:
    """What each finding, and all of them together, do to the items.

    of_findings, changes: one entry for each finding, in their order.
    """

    of_findings: tuple[tuple[Consequence, ...], ...]
    changes: tuple[tuple[VerdictChange, ...], ...]
    together: tuple[Consequence, ...] = ()
    changes_together: tuple[VerdictChange, ...] = ()
    remarks: tuple[Sayable, ...] = ()


def consequences(
    recording: Recording, explanation: Explanation, tolerance: Tolerance | None = None
) -> Consequences:
    """Every item by the recording's clause method, as read and less what the findings add.

    An element is listed where it moves by more than 0.05 U. Verdicts are compared where limits
    are given. Empty, with the reason as a remark, where the clauses give no items.
    """
    found = explanation.findings
    none = Consequences(((),) * len(found), ((),) * len(found))
    if not found:
        return none
    if all(name in recording.imu.columns for name in ANGLE):
        return replace(none, remarks=(message("explain-items-by-angles"),))
    try:
        before = _calibrated(recording)
        after = [_calibrated(without(recording, (each.contribution,))) for each in found]
        every = after[0] if len(found) == 1 else _calibrated(
            without(recording, [each.contribution for each in found])
        )  # fmt: skip
    except Unusable as fault:
        return replace(none, remarks=(message("explain-items-not-estimated", reason=str(fault)),))
    judged = _judge(tolerance, before)
    return Consequences(
        of_findings=tuple(tuple(moved(before, each)) for each in after),
        changes=tuple(tuple(judged(each)) for each in after),
        together=tuple(moved(before, every)),
        changes_together=tuple(judged(every)),
        remarks=_of_all_together(tuple(moved(before, every)), tuple(judged(every)), len(found)),
    )


def without(recording: Recording, contributions: Sequence[np.ndarray]) -> Recording:
    """The recording less what each contribution (n, 6), rad/s and m/s², added to its readings.

    Rows where a contribution is not known stay as they were read.
    """
    added = np.zeros((len(recording.imu), len(CHANNELS)))
    for each in contributions:
        added += np.nan_to_num(each, nan=0.0)
    columns = dict(recording.imu.columns)
    for channel, name in enumerate(CHANNELS):
        if name in columns and added[:, channel].any():
            columns[name] = columns[name] - added[:, channel]
    return replace(recording, imu=Stream(recording.imu.t, columns))


def moved(before: Calibration, after: Calibration) -> Iterator[Consequence]:
    """The elements that differ by more than 0.05 U, or that only one of the two determines."""
    for name, item in before.items.items():
        values = after.items[name].value if name in after.items else {}
        for element, value in item.value.items():
            now, U = values.get(element), item.U.get(element)
            if value is None and now is None:
                continue
            if value is not None and now is not None and abs(now - value) <= NOTICEABLE * (U or 0):
                continue
            yield Consequence(
                item=name, element=element, before=value, after=now, U=U, unit=item.unit
            )


def moved_by(seen: Consequence) -> float:
    """By how many U an element moves; 0 where it has no value or no U."""
    if seen.before is None or seen.after is None or not seen.U:
        return 0.0
    return abs(seen.after - seen.before) / seen.U


def _calibrated(recording: Recording) -> Calibration:
    """All items by the clause method that the recording was made for; nothing is kept."""
    specification = specification_for(recording.manifest.standard)
    return calibrate(specification, recording, run="", code_version="")


def _judge(
    tolerance: Tolerance | None, before: Calibration
) -> Callable[[Calibration], Iterator[VerdictChange]]:
    """Compares verdicts with those before; finds none where there are no limits for the items."""
    if tolerance is None:
        return lambda _: iter(())
    try:
        first = conformity.decide(before, tolerance)
    except Unusable:  # limits of another specification's items
        return lambda _: iter(())
    return lambda after: _changes(first, conformity.decide(after, tolerance))


def _changes(before: Decision, after: Decision) -> Iterator[VerdictChange]:
    now = _of_items(after)
    for item, verdict in _of_items(before).items():
        if now[item] != verdict:
            yield VerdictChange(item=item, before=verdict, after=now[item])
    if before.verdict != after.verdict:
        yield VerdictChange(item=OVERALL, before=before.verdict, after=after.verdict)


def _of_items(decision: Decision) -> dict[str, str]:
    """The worst verdict of each item's elements."""
    worst: dict[str, str] = {}
    for made in decision.limits:
        said = worst.get(made.item, "pass")
        worst[made.item] = max(said, made.verdict, key=SEVERITY.index)
    return worst


def _of_all_together(
    together: tuple[Consequence, ...], changes: tuple[VerdictChange, ...], findings: int
) -> tuple[Sayable, ...]:
    """The sentence about all findings at once, where there are several."""
    if findings < 2 or not together:
        return ()
    moves = message("explain-together-move", findings=findings, elements=len(together))
    most = max(together, key=moved_by)
    if most.before is not None and most.after is not None:
        texts = column([most.before, most.after], [most.U, most.U])
        power = f"·10^{texts.exponent}" if texts.exponent else ""
        moves = message(
            "explain-together-move-most", findings=findings, elements=len(together),
            item=ITEMS[most.item].title if most.item in ITEMS else most.item,
            element=most.element, before=texts.values[0] or "",
            after=f"{texts.values[1]}{power}", unit=unit_text(most.unit),
            expanded=f"{moved_by(most):.1f}",
        )  # fmt: skip
    verdicts = (
        message("explain-verdict-change", item=c.item, before=c.before, after=c.after)
        for c in changes
    )
    return (message("explain-together", clauses=clauses([moves, *verdicts])),)
