"""How far the parameters of findings depend on other findings that are implausible.

A term fitted far beyond its plausible range has the wrong form, and biases the estimates of the
terms that are correlated with it (misspecified regressors).
"""

from collections.abc import Collection

import numpy as np

from tasks.explain.evidence.evidence import Evidence
from tasks.explain.search.refit import fitted
from tasks.model.term import places


def change_without(evidence: Evidence, numbers: Collection[int]) -> np.ndarray:
    """(q,) by how much each column's factor changes, in the unit of its parameter, when some
    findings are left out and all else is fitted again; 0 for the columns of those findings.

    numbers: of the findings.
    """
    model, blocks = evidence.fit.model, evidence.fit.blocks
    keys = {term.key for number in numbers for term in evidence.groups[number].terms}
    rest = fitted(model.without(keys), blocks, evidence.fit.noises)
    own, values = model.places, model.values.copy()
    for term, place in zip(rest.terms, places(rest.terms), strict=True):
        values[own[term.key]] = rest.values[place]
    change = np.zeros(evidence.whole.count)
    change[: int(model.free.sum())] = np.abs(values - model.values)[model.free]
    return change
