"""Adds lines to uncertainty budgets for corrections that are themselves uncertain."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.calibration import Elements, Item
from schemas.text import text_fields
from schemas.uncertainty import Budget, BudgetInput, Correlation
from tasks.calibrate.evaluation import common_factor, expanded
from tasks.explain.correction.sensitivity import UncertainInput
from tasks.uncertainty.budget import half_width
from tasks.uncertainty.propagation import coverage_factor, variance_terms
from tasks.words import message, statement


@dataclass(frozen=True)
class CorrectionLines:
    """The budget lines of the corrections: inputs with their correlation (m, m).

    changes: for each input, the change of each element for its standard uncertainty.
    """

    inputs: Sequence[UncertainInput]
    correlation: np.ndarray
    changes: Sequence[Elements]

    @classmethod
    def of(
        cls, inputs: Sequence[UncertainInput], correlation: np.ndarray,
        item: Item, moved: Sequence[Item],
    ) -> "CorrectionLines":  # fmt: skip
        """moved: the item with each parameter greater by its standard uncertainty."""
        return cls(inputs, correlation, [_change(item, other) for other in moved])

    def at(self, element: str) -> np.ndarray:
        """(m,) changes of one element."""
        return np.array([change.get(element) or 0.0 for change in self.changes])

    def u(self, element: str) -> float:
        """The contribution of the corrections to the standard uncertainty of an element, in
        quadrature.
        """
        return math.sqrt(max(float(variance_terms(self.at(element), self.correlation).sum()), 0.0))

    @property
    def symbols(self) -> list[str]:
        """One for each input; those of one name are numbered."""
        seen, symbols = Counter[str](), []
        for one in self.inputs:
            symbol = f"{one.finding.effect}.{one.parameter.name}"
            seen[symbol] += 1
            symbols.append(symbol if seen[symbol] == 1 else f"{symbol}.{seen[symbol]}")
        return symbols

    def budget_inputs(self, element: str, u_c: float) -> tuple[BudgetInput, ...]:
        """The lines in the budget of one element, whose combined uncertainty is u_c."""
        changes = self.at(element)
        shares = variance_terms(changes, self.correlation) / u_c**2
        every = zip(self.inputs, self.symbols, changes.tolist(), shares.tolist(), strict=True)
        return tuple(_line(one, symbol, change, share) for one, symbol, change, share in every)

    def correlations(self, element: str) -> tuple[Correlation, ...]:
        """Of the inputs that change an element."""
        changes, symbols = self.at(element), self.symbols
        both = np.triu(self.correlation, 1) * (changes[:, None] * changes != 0.0)
        return tuple(
            Correlation(first=symbols[i], second=symbols[j], r=float(np.clip(both[i, j], -1, 1)))
            for i, j in zip(*np.nonzero(both), strict=True)
        )


def with_lines(item: Item, lines: CorrectionLines) -> Item:
    """An item with further lines in the budget of each element."""
    if not lines.inputs:
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
            e: None if u is None else math.hypot(u, lines.u(e))
            for e, u in item.u_without_earth_rotation.items()
        }
        update["u_without_earth_rotation"] = u
        update["U_without_earth_rotation"] = {e: None if v is None else k * v for e, v in u.items()}
    return item.model_copy(update=update)


def _with_lines(budget: Budget, element: str, lines: CorrectionLines) -> Budget:
    """A budget with further lines, of infinitely many degrees of freedom, beside its own."""
    u_c = math.hypot(budget.u_c, lines.u(element))
    if u_c == 0.0:
        return budget
    share = (budget.u_c / u_c) ** 2
    before = (line.model_copy(update={"share": line.share * share}) for line in budget.inputs)
    inputs = (*before, *lines.budget_inputs(element, u_c))
    correlations = (*budget.correlations, *lines.correlations(element))
    dof = budget.dof * (u_c / budget.u_c) ** 4 if budget.u_c > 0.0 else math.inf
    k = coverage_factor(dof, budget.coverage_probability)
    shapes = [(line.distribution, line.contribution, line.dof) for line in inputs]
    by_shapes = budget.half_width_95 is not None and not correlations
    return budget.model_copy(
        update={
            "inputs": inputs, "correlations": correlations, "u_c": u_c, "dof": dof, "k": k,
            "U": k * u_c, "half_width_95": half_width(shapes) if by_shapes else None,
        }
    )  # fmt: skip


def _change(item: Item, moved: Item) -> Elements:
    change: Elements = {}
    for element, value in item.value.items():
        other = moved.value.get(element)
        change[element] = None if value is None or other is None else other - value
    return change


def _line(one: UncertainInput, symbol: str, change: float, share: float) -> BudgetInput:
    parameter = one.parameter
    name = message("explain-budget-line", title=one.finding.title, parameter=parameter.name)
    return BudgetInput(
        **text_fields("name", statement(name)), symbol=symbol, kind="A",
        distribution="normal", u=parameter.u, unit=parameter.unit,
        sensitivity=change / parameter.u, contribution=abs(change), share=share,
    )  # fmt: skip
