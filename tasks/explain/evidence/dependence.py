"""How far the parameters of findings depend on other findings that are implausible.

A term fitted far beyond its plausible range has the wrong form, and biases the estimates of the
terms that are correlated with it (misspecified regressors).
"""

from collections.abc import Collection

import numpy as np

from tasks.explain.evidence.evidence import Evidence
from tasks.explain.search.refit import fitted


def change_without(evidence: Evidence, numbers: Collection[int]) -> np.ndarray:
    """(q,) by how much each column's factor changes, in the unit of its parameter, when some
    findings are left out and all else is fitted again; 0 for the columns of those findings.

    numbers: of the findings.
    """
    model, blocks = evidence.fit.model, evidence.fit.blocks
    keys = {term.key for number in numbers for term in evidence.groups[number].terms}
    rest = fitted(model.without(keys), blocks, evidence.fit.noises)
    moved = np.abs(model.with_values_of(rest).values - model.values)
    change = np.zeros(evidence.whole.count)
    change[: int(model.free.sum())] = moved[model.free]
    return change
