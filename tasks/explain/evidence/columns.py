"""The columns by which the findings of a fitted model are judged."""

from collections.abc import Sequence

import numpy as np

from tasks.explain.evidence.groups import FindingGroup
from tasks.model.model import Model
from tasks.model.term import Column
from tasks.motion.whole import Motion


def fitted_columns(
    model: Model, groups: Sequence[FindingGroup], motion: Motion
) -> tuple[list[Column], np.ndarray]:
    """Of a model's free parameters, then of known physics in the order of the groups; and what
    the model predicts, (n, 6).
    """
    design = model.linearised(motion, model.free)
    columns = [design.columns[p] for p in np.flatnonzero(model.free).tolist()]
    for term in (term for group in groups for term in group.terms if not term.parameters):
        effect = model.effect_of({term.key}, motion, design.prediction)
        columns.append(dict(enumerate(effect.T)))
    return columns, design.prediction
