"""The uncertainty budget of one element."""

import dash_mantine_components as dmc
from dash.development.base_component import Component

from flows.pages.parts import Page, said, say, table
from flows.pages.run_data import BudgetQuestion, BudgetShown
from schemas.base import Unusable
from storage.catalogue import results
from storage.home import Home
from tasks.conformity.capabilities import name_of
from tasks.specifications.estimate import item_title, symbol
from tasks.words import statement
from tasks.words.numbers import column, plain, power_of_ten, unit_text


def data(question: BudgetQuestion, home: Home) -> BudgetShown:
    """The budget of an element by the run's newest result; Unusable where there is none."""
    result = results.find(question.run, home)
    item = result.calibration.items.get(question.item)
    budget = item.budgets.get(question.element) if item else None
    if budget is None:
        raise Unusable(
            f"result {result.id} of run {result.run} has no budget of {question.item} "
            f"{question.element}; GET /api/v1/run?id={result.run} lists those that have one"
        )
    return BudgetShown(
        run=result.run,
        result=result.id,
        title=statement(item_title(question.item)),
        symbol=symbol(question.item, question.element),
        budget=budget,
    )


def layout(shown: BudgetShown, _: BudgetQuestion) -> Component:
    """A line for each input, as the certificate prints them."""
    budget = shown.budget
    unit = unit_text(budget.unit)
    rows = [
        (
            f"{say(name_of(each))} ({each.symbol})",
            f"{each.kind}, {said(f'pages-distribution.{each.distribution}')}",
            f"{plain(each.u)} {unit_text(each.unit)}",
            plain(each.sensitivity),
            f"{plain(each.contribution)} {unit}",
            f"{100 * each.share:.1f} %",
            each.source,
        )
        for each in budget.inputs
    ]
    printed = column([budget.value], [budget.U], budget.k)
    power = f"{power_of_ten(printed.exponent)} ".lstrip()
    summary = said(
        "pages-budget-summary", item=shown.title, symbol=shown.symbol,
        value=f"{printed.values[0]} {power}{unit}",
        u=f"{plain(budget.u_c)} {unit}", k=f"{budget.k:.3g}",
        expanded=f"{printed.uncertainties[0]} {power}{unit}",
    )  # fmt: skip
    names = "input kind u sensitivity contribution share source"
    return dmc.Stack(
        [
            dmc.Text(summary),
            table("pages-budget-column", names, rows),
        ]
    )


PAGE = Page("budget", BudgetQuestion, BudgetShown, data, layout, in_navigation=False)
