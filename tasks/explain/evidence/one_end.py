"""Whether enough of a recording lies on both sides of a step to identify it as one.

A bias that jumps is the same before and the same after. What the first few cells of a recording, or
the last, have of their own is no jump for that: a warm-up, or a rest that is unlike all the motion
after it, sets them apart as well, and too few cells do not tell that their bias is one.
"""

import numpy as np

from tasks.explain.evidence.cells import scatter_cells
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.explanation import Refusal

FEWEST = 3  # cells on either side: two tell a change by themselves


def jump_at_one_end(evidence: Evidence, number: int) -> Refusal | None:
    """The jump that has too few cells before or after it to show that the bias is constant
    there.
    """
    group, blocks = evidence.groups[number], evidence.fit.blocks
    times = [term.at[0] for term in group.terms if term.time_course == "jump"]
    if not times:
        return None
    cells, used = scatter_cells(blocks), (blocks.weight > 0).any(axis=1)
    before, after = (
        len(np.unique(cells[used & side]))
        for side in (blocks.t < min(times), blocks.t > max(times))
    )
    if min(before, after) >= FEWEST:
        return None
    return Refusal("one_end", group.name, value=float(min(before, after)))
