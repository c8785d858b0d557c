"""Items with further lines in their uncertainty budgets, of corrections that are uncertain."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from schemas.calibration import Elements, Item
from schemas.uncertainty import Budget, BudgetInput
from tasks.calibrate.evaluation import common_factor, expanded
from tasks.explain.correction.sensitivity import Sensitivity
from tasks.uncertainty.coverage import half_width
from tasks.uncertainty.propagation import coverage_factor
from tasks.words import message, say


@dataclass(frozen=True)
class CorrectionLine:
    """A budget's line, by how much each element changes with the parameter's uncertainty."""

    sensitivity: Sensitivity
    change: Elements

    @classmethod
    def of(cls, sensitivity: Sensitivity, item: Item, moved: Item) -> "CorrectionLine":
        """moved: the item with the parameter greater by its standard uncertainty."""
        change: Elements = {}
        for element, value in item.value.items():
            other = moved.value.get(element)
            change[element] = None if value is None or other is None else other - value
        return cls(sensitivity, change)

    def at(self, element: str) -> float:
        return self.change.get(element) or 0.0

    def input(self, element: str, u_c: float) -> BudgetInput:
        """The line in the budget of one element, whose combined uncertainty is u_c."""
        finding, parameter = self.sensitivity.finding, self.sensitivity.parameter
        name = message("explain-budget-line", title=finding.title, parameter=parameter.name)
        change = self.at(element)
        return BudgetInput(
            name=say(name, "en"), name_zh=say(name, "zh"),
            symbol=f"{finding.effect}.{parameter.name}", kind="A", distribution="normal",
            u=parameter.u, unit=parameter.unit, sensitivity=change / parameter.u,
            contribution=abs(change), share=(change / u_c) ** 2,
        )  # fmt: skip


def with_lines(item: Item, lines: Sequence[CorrectionLine]) -> Item:
    """An item with further lines in the budget of each element."""
    if not lines:
        return item
    budgets = {e: _with_lines(budget, e, lines) for e, budget in item.budgets.items()}
    k = common_factor(budgets)
    budgets = {element: expanded(budget, k) for element, budget in budgets.items()}
    update = {
        "budgets": budgets,
        "u": item.u | {element: budget.u_c for element, budget in budgets.items()},
        "U": item.U | {element: budget.U for element, budget in budgets.items()},
        "k": k,
    }
    if item.u_without_earth_rotation:
        u = {
            e: None if u is None else math.hypot(u, *(line.at(e) for line in lines))
            for e, u in item.u_without_earth_rotation.items()
        }
        update["u_without_earth_rotation"] = u
        update["U_without_earth_rotation"] = {e: None if v is None else k * v for e, v in u.items()}
    return item.model_copy(update=update)


def _with_lines(budget: Budget, element: str, lines: Sequence[CorrectionLine]) -> Budget:
    """A budget with further independent lines of infinitely many degrees of freedom."""
    u_c = math.hypot(budget.u_c, *(line.at(element) for line in lines))
    if u_c == 0.0:
        return budget
    share = (budget.u_c / u_c) ** 2
    before = (line.model_copy(update={"share": line.share * share}) for line in budget.inputs)
    inputs = (*before, *(line.input(element, u_c) for line in lines))
    dof = budget.dof * (u_c / budget.u_c) ** 4 if budget.u_c > 0.0 else math.inf
    k = coverage_factor(dof, budget.coverage_probability)
    shapes = [(line.distribution, line.contribution, line.dof) for line in inputs]
    return budget.model_copy(
        update={
            "inputs": inputs, "u_c": u_c, "dof": dof, "k": k, "U": k * u_c,
            "half_width_95": None if budget.half_width_95 is None else half_width(shapes),
        }
    )  # fmt: skip
