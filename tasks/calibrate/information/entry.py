"""An entry of the result's information."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from schemas.calibration import Elements, Information, Item
from schemas.recording import AXES
from schemas.text import text_fields
from tasks.uncertainty.propagation import coverage_factor
from tasks.words import Message, clauses, message, statement, worded
from tasks.words.rounding import USUAL_K

Numbers = Sequence[float | None] | np.ndarray


def entry(
    name: str,
    unit: str,
    value: Numbers,
    u: Numbers,
    *sentences: Message,
    elements: Iterable[str] = AXES,
    factor: float = 1.0,
    k: float = USUAL_K,
    without_U: np.ndarray | bool = False,  # noqa: N803
    about: str | None = None,
) -> Information:
    """Values with standard uncertainties, one for each element, NaN if there is none; U = k·u.

    name: of the title's message; sentences: what it is and how it was found; factor: from the
    values' unit to the printed one; about: the item it refers to. without_U: u is not a complete
    uncertainty, so that no U is stated.
    """
    title = message(f"information-{name.replace('_', '-')}")
    values = factor * np.array(value, float)
    us = np.where(np.isfinite(values), factor * np.array(u, float), np.nan)
    expanded = np.where(without_U, np.nan, k * us)

    def known(numbers: np.ndarray) -> Elements:
        finite = (float(n) if np.isfinite(n) else None for n in numbers)
        return dict(zip(elements, finite, strict=True))

    return Information(
        **text_fields("title", statement(title)),
        unit=unit,
        value=known(values),
        u=known(us),
        U=known(expanded),
        k=k,
        about=about,
        **worded(clauses(sentences, by="report-sentences")),
    )


def student_k(dof: np.ndarray) -> float:
    """k by Student's t for the fewest degrees of freedom (n,) that there are, rounded up to two
    decimals as that of an item; NaN or 0: none.
    """
    k = coverage_factor(float(min(dof[dof > 0], default=math.inf)))
    return math.ceil(100 * round(k, 9)) / 100


def of_axes(id_: str, axes: Sequence[str], **arguments: str) -> list[Message]:
    """A sentence about some axes; none for no axes."""
    return [message(id_, axes=", ".join(axes), **arguments)] if axes else []


def type_b(item: Item | None, elements: Iterable[str]) -> np.ndarray:
    """What the equipment adds to u of each element of an item, by its budget; NaN without one."""
    budgets = item.budgets if item else {}
    return np.array([
        math.sqrt(sum(line.contribution**2 for line in budgets[element].inputs if line.kind == "B"))
        if element in budgets
        else math.nan
        for element in elements
    ])  # fmt: skip


def or_why_not(u: np.ndarray) -> list[Message]:
    """The sentence on what u (n,) includes: type B as well, or why there is none."""
    known = bool(np.isfinite(u).any())
    return [message(f"information-type-b.{'contained' if known else 'not-evaluated'}")]


def without_type_b(u: np.ndarray, elements: Sequence[str]) -> list[Message]:
    """Which elements have no U where others have one: the equipment's share is of no budget."""
    known = np.isfinite(u)
    bare = [element for element, has in zip(elements, known, strict=True) if not has]
    named = bare if known.any() else []
    return [message("information-type-b.in-part", elements=", ".join(named))] if named else []


def unit_and_table(values: np.ndarray) -> list[Message]:
    """Why no type B is added to a figure (n,) that has the table in it; none without a figure."""
    return [message("information-type-b.unit-and-table")] if np.isfinite(values).any() else []
