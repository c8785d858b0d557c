"""One way of partitioning a run into cells, and its words."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from schemas.discrepancy import Dimension
from tasks.words import Message, Sayable, message


@dataclass(frozen=True)
class Partition:
    """One way of partitioning the run into k cells.

    cell: (m,) the cell of each block, −1 where it is not known. ordered: cells next to each
    other belong together. variable: what the cells differ in. cells: what each is called.
    circumstance: the words for some cells, in their order. recorded: by a signal that the run
    did not command: power that happens to coincide with a part of its range means nothing, only
    what varies with it does.
    """

    dimension: Dimension
    cell: np.ndarray
    ordered: bool
    variable: Sayable
    cells: tuple[Message, ...]
    circumstance: Callable[[Sequence[int]], Sayable]
    recorded: bool = False


def unordered(
    dimension: Dimension,
    cell: np.ndarray,
    variable: Sayable,
    cells: tuple[Message, ...],
    names: tuple[Sayable, ...] | None = None,
    frame: str | None = None,
) -> Partition:
    """Cells without an order, listed: «while +x or +y is up».

    names: of the cells in such a list, which the message `frame` takes; else `cells` themselves.
    """
    listed: tuple[Sayable, ...] = cells if names is None else names

    def circumstance(chosen: Sequence[int]) -> Sayable:
        either = reduce(_or, (listed[k] for k in chosen))
        return message(frame, cells=either) if frame else either

    return Partition(dimension, cell, False, variable, cells, circumstance)


def _or(first: Sayable, second: Sayable) -> Sayable:
    return message("locate-or", first=first, second=second)
