"""One way of parting a run into cells."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import Dimension
from tasks.model.term import Text


@dataclass(frozen=True)
class Regime:
    """One way of parting the run into k cells.

    cell: (m,) the cell of each block, −1 where it is not known. ordered: cells next to each
    other belong together. follows: what it goes by. cells: what each cell is called.
    at: says «at such cells» of cells in their order. recorded: a course that the run did not
    command: power that happens to fall together with a part of its range tells nothing, only
    what goes by it does.
    """

    dimension: Dimension
    cell: np.ndarray
    ordered: bool
    follows: Text
    cells: tuple[Text, ...]
    at: Callable[[list[int]], Text]
    recorded: bool = False


def listed(cells: tuple[Text, ...], frame: Text) -> Callable[[list[int]], Text]:
    """«while +x, +y are up»: cells without an order, listed."""

    def at(chosen: list[int]) -> Text:
        english = " or ".join(cells[k][0] for k in chosen)
        return frame[0].format(english), frame[1].format("、".join(cells[k][1] for k in chosen))

    return at
