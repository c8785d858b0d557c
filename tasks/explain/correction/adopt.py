"""A calibration with found physics taken off the readings first, and what that costs in U."""

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from schemas.calibration import AdoptedParameter, AdoptedTerm, Calibration, Elements, Item, Remark
from schemas.recording import Recording
from schemas.uncertainty import Budget, BudgetInput
from tasks.calibrate.evaluation import common_factor, expanded
from tasks.explain.correction.consequences import without
from tasks.explain.correction.sensitivity import Sensitivity, sensitivities
from tasks.explain.explanation import Finding
from tasks.model.term import Term
from tasks.model.terms.memory import BIAS_RANDOM_WALK
from tasks.motion.whole import Motion
from tasks.uncertainty.coverage import half_width
from tasks.uncertainty.propagation import coverage_factor
from tasks.words import Message, clauses, message, remark, say

Calibrate = Callable[[Recording], Calibration]
EARTH, G_SENSITIVITY = "earth_rotation", "gyro_g_sensitivity"


def adopt(
    recording: Recording,
    findings: Sequence[Finding],
    calibrate: Calibrate,
    terms: Sequence[Term],
    motion: Motion,
) -> Calibration:
    """The clause method on the readings less what the findings add.

    terms: of the catalogue, among which are those of the findings; motion: at the unit's rows.
    U holds the parameters' uncertainties beside all the rest: u² = u₀² + Σ(∂y/∂p·u_p)², each by
    a difference, the parameters independent of each other and of the readings' noise. A random
    course has no parameter whose uncertainty U could hold: it stays in the readings, as noise.
    """
    wandering = [finding for finding in findings if finding.effect == BIAS_RANDOM_WALK.name]
    findings = [finding for finding in findings if finding.effect != BIAS_RANDOM_WALK.name]
    contributions = [finding.contribution for finding in findings]
    result = calibrate(without(recording, contributions))
    spreads = [s for finding in findings for s in sensitivities(finding, terms, motion)]
    moved = [(s, calibrate(without(recording, (*contributions, s.change)))) for s in spreads]
    items = {
        name: _item(item, [_line(spread, each.items[name], item) for spread, each in moved])
        for name, item in result.items.items()
    }
    names = [finding.effect for finding in findings]
    remarks, unavailable, unavailable_zh = result.remarks, result.unavailable, result.unavailable_zh
    if EARTH in names and G_SENSITIVITY in items:
        items[G_SENSITIVITY] = _earth_taken_off(items[G_SENSITIVITY])
        remarks = tuple(r for r in remarks if not r.code.startswith(EARTH))
        if None not in items[G_SENSITIVITY].value.values():
            unavailable, unavailable_zh = (
                {name: why for name, why in each.items() if name != G_SENSITIVITY}
                for each in (unavailable, unavailable_zh)
            )
    return result.model_copy(
        update={
            "items": items,
            "terms": tuple(map(adopted_term, findings)),
            "information": calibrate(recording).information,  # of the readings as they are
            "remarks": (
                *adoption_remarks(result, recording, findings),
                *map(_stays, wandering),
                *remarks,
            ),
            "unavailable": unavailable,
            "unavailable_zh": unavailable_zh,
        }
    )


def adopted_term(finding: Finding) -> AdoptedTerm:
    """What a result says of a finding that was taken off."""
    return AdoptedTerm(
        name=finding.effect,
        title=say(finding.title, "en"),
        title_zh=say(finding.title, "zh"),
        parameters=tuple(AdoptedParameter(**p.model_dump()) for p in finding.parameters),
    )


def _line(spread: Sensitivity, moved: Item, item: Item) -> tuple[BudgetInput, Elements]:
    """A budget's line without its sensitivity, and by how much each element moves."""
    parameter = spread.parameter
    change: Elements = {}
    for element, value in item.value.items():
        other = moved.value.get(element)
        change[element] = None if value is None or other is None else other - value
    name = message("explain-budget-line", title=spread.finding.title, parameter=parameter.name)
    line = BudgetInput(
        name=say(name, "en"), name_zh=say(name, "zh"),
        symbol=f"{spread.finding.effect}.{parameter.name}", kind="A", distribution="normal",
        u=parameter.u, unit=parameter.unit, sensitivity=0.0, contribution=0.0, share=0.0,
    )  # fmt: skip
    return line, change


def _item(item: Item, lines: Sequence[tuple[BudgetInput, Elements]]) -> Item:
    """An item with further lines in the budget of each element."""
    if not lines:
        return item
    budgets = {
        element: _budget(budget, [(line, change.get(element) or 0.0) for line, change in lines])
        for element, budget in item.budgets.items()
    }
    k = common_factor(budgets)
    budgets = {element: expanded(budget, k) for element, budget in budgets.items()}
    still = {
        element: None if u is None else math.hypot(u, *(c.get(element) or 0.0 for _, c in lines))
        for element, u in (item.u_without_earth_rotation or {}).items()
    }
    return item.model_copy(
        update={
            "budgets": budgets,
            "u": item.u | {element: budget.u_c for element, budget in budgets.items()},
            "U": item.U | {element: budget.U for element, budget in budgets.items()},
            "k": k,
            "u_without_earth_rotation": still or item.u_without_earth_rotation,
            "U_without_earth_rotation": {e: None if u is None else k * u for e, u in still.items()}
            or item.U_without_earth_rotation,
        }
    )


def _budget(budget: Budget, more: Sequence[tuple[BudgetInput, float]]) -> Budget:
    """A budget with further independent lines of infinitely many degrees of freedom."""
    u_c = math.hypot(budget.u_c, *(change for _, change in more))
    if u_c == 0.0:
        return budget
    before = [
        line.model_copy(update={"share": line.share * (budget.u_c / u_c) ** 2})
        for line in budget.inputs
    ]
    added = [
        line.model_copy(
            update={
                "sensitivity": change / line.u,
                "contribution": abs(change),
                "share": (change / u_c) ** 2,
            }
        )
        for line, change in more
    ]
    dof = budget.dof * (u_c / budget.u_c) ** 4 if budget.u_c > 0.0 else math.inf
    k = coverage_factor(dof, budget.coverage_probability)
    inputs = (*before, *added)
    shapes = [(line.distribution, line.contribution, line.dof) for line in inputs]
    return budget.model_copy(
        update={
            "inputs": inputs, "u_c": u_c, "dof": dof, "k": k, "U": k * u_c,
            "half_width_95": None if budget.half_width_95 is None else half_width(shapes),
        }
    )  # fmt: skip


def _earth_taken_off(item: Item) -> Item:
    """The g-sensitivity of readings without Earth's rotation is the one without it."""
    return item.model_copy(
        update={
            "value_without_earth_rotation": item.value,
            "u_without_earth_rotation": item.u,
            "U_without_earth_rotation": item.U,
        }
    )


def adoption_remarks(
    result: Calibration, recording: Recording, findings: Sequence[Finding]
) -> Iterator[Remark]:
    """What was taken off, what of it is not shown by the recording, and where it is not known."""
    if not findings:
        return
    terms = clauses([_described(finding) for finding in findings])
    yield remark("terms_adopted", message("explain-adopted", terms=terms), blocks_pass=True)
    for finding in findings:
        if finding.delta_bic <= 0.0:
            bic = f"{finding.delta_bic:.1f}"
            said = message("explain-adopted-not-shown", term=_named(finding), bic=bic)
            yield remark("term_not_shown", said)
    unknown = _not_known(result, recording, findings)
    if unknown:
        said = message("explain-adopted-motion-unknown", segments=unknown)
        yield remark("term_not_known", said, segments=unknown)


def _stays(finding: Finding) -> Remark:
    return remark("term_not_taken_off", message("explain-not-adopted-random", term=_named(finding)))


def _named(finding: Finding) -> Message:
    return message("explain-adopted-term", title=finding.title, name=finding.effect)


def _described(finding: Finding) -> Message:
    """A finding with its parameters."""
    if not finding.parameters:
        return _named(finding)
    return message(
        "explain-adopted-term-parameters",
        title=finding.title,
        name=finding.effect,
        parameters=tuple(
            f"{p.name} = {p.value:.4g} {p.unit} (u = {p.u:.2g})" for p in finding.parameters
        ),
    )


def _not_known(
    result: Calibration, recording: Recording, findings: Sequence[Finding]
) -> tuple[str, ...]:
    """The segments used that have rows without a known contribution."""
    unknown = np.zeros(len(recording.imu), dtype=bool)
    for finding in findings:
        unknown |= ~np.isfinite(finding.contribution[:, list(finding.channels)]).all(axis=1)
    used = ((s.name, recording.imu.rows(s.t_start, s.t_end)) for s in result.segments)
    return tuple(name for name, rows in used if unknown[rows].any())
