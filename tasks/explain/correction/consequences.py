"""What leaving the physics out does to the certificate: each item before and after."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.decision import Decision
from schemas.discrepancy import Consequence, VerdictChange
from schemas.recording import ANGLE, Recording
from schemas.tolerance import Tolerance
from tasks import conformity
from tasks.calibrate.calibrate import calibrate
from tasks.explain.correction.corrected import corrected
from tasks.explain.explanation import Explanation
from tasks.specifications.register import specification_for
from tasks.words import Sayable, message

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
    contributions = [finding.contribution for finding in explanation.findings]
    count = len(contributions)
    none = Consequences(((),) * count, ((),) * count)
    if not count:
        return none
    if all(name in recording.imu.columns for name in ANGLE):
        return replace(none, remarks=(message("explain-items-by-angles"),))
    try:
        before = _calibrated(recording)
        after = [_calibrated(corrected(recording, (each,))) for each in contributions]
        whole = after[0] if count == 1 else _calibrated(corrected(recording, contributions))
    except Unusable as fault:
        return replace(none, remarks=(message("explain-items-not-estimated", reason=str(fault)),))
    changes = _verdict_changes(tolerance, before, [*after, whole])
    return Consequences(
        of_findings=tuple(tuple(moved(before, each)) for each in after),
        changes=tuple(changes[:-1]),
        together=tuple(moved(before, whole)),
        changes_together=changes[-1],
    )


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


def shift(consequence: Consequence) -> float:
    """By how many U an element moves, with its sign; 0 where it has no value or no U."""
    if consequence.before is None or consequence.after is None or not consequence.U:
        return 0.0
    return (consequence.after - consequence.before) / consequence.U


def moved_by(consequence: Consequence) -> float:
    """By how many U an element moves either way."""
    return abs(shift(consequence))


def _calibrated(recording: Recording) -> Calibration:
    """All items by the clause method that the recording was made for; nothing is kept."""
    specification = specification_for(recording.manifest.standard)
    return calibrate(specification, recording, run="", code_version="")


def _verdict_changes(
    tolerance: Tolerance | None, before: Calibration, after: Sequence[Calibration]
) -> list[tuple[VerdictChange, ...]]:
    """For each calibration its verdicts beside those before; none without limits for the items."""
    if tolerance is None:
        return [()] * len(after)
    try:
        first = _verdicts(conformity.decide(before, tolerance))
    except Unusable:  # limits of another specification's items
        return [()] * len(after)
    return [_changes(first, _verdicts(conformity.decide(each, tolerance))) for each in after]


def _changes(before: dict[str, str], after: dict[str, str]) -> tuple[VerdictChange, ...]:
    return tuple(
        VerdictChange(item=item, before=verdict, after=after[item])
        for item, verdict in before.items()
        if after[item] != verdict
    )


def _verdicts(decision: Decision) -> dict[str, str]:
    """The worst verdict of each item's elements, and that of the certificate as a whole."""
    worst: dict[str, str] = {}
    for limit in decision.limits:
        verdicts = (worst.get(limit.item, "pass"), limit.verdict)
        worst[limit.item] = max(verdicts, key=SEVERITY.index)
    return worst | {OVERALL: decision.verdict}
