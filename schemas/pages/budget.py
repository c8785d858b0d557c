"""The uncertainty budget of one element of a run's newest result."""

from pydantic import Field

from schemas.base import Frozen
from schemas.text import Statement
from schemas.uncertainty import Budget


class BudgetQuestion(Frozen):
    """Which element of which item of which run."""

    run: str = Field(min_length=1, max_length=200)
    item: str = Field(min_length=1, max_length=100)
    element: str = Field(min_length=1, max_length=10)


class BudgetShown(Frozen):
    """A budget and what it is of. result: by its id."""

    run: str
    result: str
    title: Statement
    symbol: str
    budget: Budget
