"""How the missing physics changes the certificate: each item before and after."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations

import numpy as np
from scipy.sparse.csgraph import connected_components

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.discrepancy import Consequence, VerdictChange
from schemas.laboratory import EquipmentLimit, LimitName
from schemas.recording import ANGLE, Recording
from schemas.tolerance import Decision, Tolerance
from tasks import conformity
from tasks.calibrate.calibrate import evaluation_for, without_information
from tasks.explain.correction.adopt import Calibrate, Corrections, corrected
from tasks.explain.explanation import Explanation
from tasks.specifications.register import specification_for
from tasks.words import Sayable, message

NOTICEABLE = 0.05  # of U: what moves an element by less is not listed
SEVERITY = ("pass", "inconclusive", "fail")
OVERALL = "certificate"
COLLINEAR = 0.7  # correlation of parameters from which on two findings are told of together


@dataclass(frozen=True)
class Consequences:
    """What each finding, and all of them together, do to the items.

    of_findings, changes: one entry for each finding, in their order. sets: of each the numbers of
    those whose consequences are told together, its own included.
    """

    of_findings: tuple[tuple[Consequence, ...], ...]
    changes: tuple[tuple[VerdictChange, ...], ...]
    together: tuple[Consequence, ...] = ()
    changes_together: tuple[VerdictChange, ...] = ()
    remarks: tuple[Sayable, ...] = ()
    sets: tuple[tuple[int, ...], ...] = ()


def consequences(
    recording: Recording,
    explanation: Explanation,
    tolerance: Tolerance | None = None,
    limits: Mapping[LimitName, EquipmentLimit] | None = None,
) -> Consequences:
    """Every item by the recording's clause method, as read and corrected for the findings.

    Findings whose parameters compensate for each other are corrected for together: one alone would
    shift what the others shift back. U includes the uncertainty of the corrections; an element is
    listed if it changes by more than 0.05 U. Verdicts are compared if limits are given. limits:
    of the equipment, as of `calibrate`. Empty, with the reason as a remark, if the clauses give no
    items.
    """
    findings = explanation.findings
    count = len(findings)
    none = Consequences(((),) * count, ((),) * count)
    if not count:
        return none
    if all(name in recording.imu.columns for name in ANGLE):
        return replace(none, remarks=(message("explain-items-by-angles"),))
    calibrated = partial(by_clauses, limits=limits)
    try:
        before = calibrated(recording)
        sets = collinear_sets(explanation)
        every = {*sets, tuple(range(count))}
        of_set = _less_what_they_add(recording, explanation, every, calibrated)
    except Unusable as fault:
        return replace(none, remarks=(message("explain-items-not-estimated", reason=str(fault)),))
    after, whole = [of_set[some] for some in sets], of_set[tuple(range(count))]
    changes = _verdict_changes(tolerance, before, [*after, whole])
    return Consequences(
        of_findings=tuple(tuple(moved(before, each)) for each in after),
        changes=tuple(changes[:-1]),
        together=tuple(moved(before, whole)),
        changes_together=changes[-1],
        sets=tuple(sets),
        remarks=tuple(
            message("explain-stated-together", titles=tuple(findings[n].title for n in some))
            for some in dict.fromkeys(sets)
            if len(some) > 1
        ),
    )


def _less_what_they_add(
    recording: Recording, explanation: Explanation, sets: Collection[tuple[int, ...]],
    calibrated: Calibrate,
) -> dict[tuple[int, ...], Calibration]:  # fmt: skip
    """The items less what each set of findings adds, with what is uncertain of that."""
    findings = explanation.findings
    every = Corrections.of(recording, findings, calibrated, explanation.determined)
    of_set = {}
    for some in sets:
        whole = len(some) == len(findings)
        contributions = [findings[n].contribution for n in some]
        less = every.calibration if whole else calibrated(corrected(recording, contributions))
        items = every.with_uncertainty(less.items, some)
        of_set[some] = less.model_copy(update={"items": items})
    return of_set


def collinear_sets(explanation: Explanation) -> list[tuple[int, ...]]:
    """For each finding the numbers of those that are nearly collinear with it, its own included."""
    findings, determined = explanation.findings, explanation.determined
    alike = np.eye(len(findings), dtype=bool)
    places = [
        [
            one.place
            for one in (determined.parameters(finding.terms) if determined else ())
            if one.place is not None and not one.held
        ]
        for finding in findings
    ]
    for i, j in combinations(range(len(findings)), 2):
        if determined is not None and places[i] and places[j]:
            r = np.abs(determined.correlation[np.ix_(places[i], places[j])])
            alike[i, j] = r.max() > COLLINEAR
    which = connected_components(alike, directed=False)[1]
    return [tuple(np.flatnonzero(which == own).tolist()) for own in which]


def moved(before: Calibration, after: Calibration) -> Iterator[Consequence]:
    """The elements that differ by more than 0.05 U, or that only one of the two determines."""
    for name, item in before.items.items():
        other = after.items.get(name)
        for element, value in item.value.items():
            now = other.value.get(element) if other else None
            stated = item.U.get(element)
            U = other.U.get(element) if other and now is not None else stated
            if value is None and now is None:
                continue
            if value is not None and now is not None and abs(now - value) <= NOTICEABLE * (U or 0):
                continue
            yield Consequence(
                item=name, element=element, before=value, after=now, U=U, U_before=stated,
                unit=item.unit,
            )  # fmt: skip


def moved_by(consequence: Consequence) -> float:
    """By how many U an element moves either way."""
    return abs(consequence.in_U)


def by_clauses(
    recording: Recording, limits: Mapping[LimitName, EquipmentLimit] | None = None
) -> Calibration:
    """All items by the clause method that the recording was made for; nothing is kept.

    limits: of the equipment, which go before those of the specification.
    """
    specification = specification_for(recording.manifest.standard)
    specification.check(recording)
    evaluation = evaluation_for(recording, own=limits)
    return without_information(specification, specification.gather(recording), evaluation)


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
