"""All pages, in the order of the navigation."""

from flows.pages import (
    budget,
    discrepancy,
    do,
    due,
    line,
    quality,
    run,
    runs,
    signals,
    unit,
)
from flows.pages.parts import Page

PAGES: tuple[Page, ...] = (
    line.PAGE,
    runs.PAGE,
    run.PAGE,
    signals.PAGE,
    budget.PAGE,
    unit.PAGE,
    due.PAGE,
    quality.PAGE,
    discrepancy.PAGE,
    do.PAGE,
)
FIRST = PAGES[0]  # what the bare address shows
