"""The covariance of all elements of a result, type A and type B together.

Elements that are combinations of the same means share their noise, and whatever the equipment was
off by: one error of the rate is in every scale factor.
"""

from collections.abc import Sequence

import numpy as np

from tasks.specifications.error_sources import EquipmentErrors
from tasks.specifications.estimate import Estimate
from tasks.specifications.evidence import ClauseEvidence


def covariance_of(
    estimates: Sequence[Estimate], evidence: ClauseEvidence, errors: EquipmentErrors
) -> np.ndarray:
    """Covariance (p, p) of estimates that are combinations of the segment means, in their units.

    Its diagonal is that of their budgets: where points scatter more than noise explains, what the
    data give is taken in the same proportion.
    """
    weights = np.array([estimate.operator for estimate in estimates], float)  # (p, 6, n)
    noise = np.zeros((len(estimates), len(estimates)))
    for channel in range(weights.shape[1]):
        used = np.flatnonzero(weights[:, channel].any(axis=0))
        of_means = evidence.covariance(channel)[np.ix_(used, used)]
        part = weights[:, channel][:, used]
        noise += part @ of_means @ part.T
    stated = np.array([estimate.u_of_data for estimate in estimates])
    shown = np.sqrt(np.maximum(np.diag(noise), 0.0))
    scale = np.divide(stated, shown, out=np.zeros_like(stated), where=shown > 0.0)
    total = noise * np.outer(scale, scale)
    free = np.array([estimate.without_earth for estimate in estimates])
    for source in errors.sources:
        felt = np.tensordot(weights, source.effects, axes=((1, 2), (2, 1)))
        if source.of_latitude:
            felt = felt * free[:, None]
        total += source.quantity.u**2 * felt @ felt.T
    return np.asarray(0.5 * (total + total.T))
