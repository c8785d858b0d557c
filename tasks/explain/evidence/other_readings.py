"""Tests the columns of all findings against readings that contain none of them."""

import numpy as np

from tasks.explain.evidence.columns import fitted_columns
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.inputs.blocks import block_means
from tasks.explain.inputs.full_rate import FullRate
from tasks.explain.whitening import equations_of


def equations_on(
    full: FullRate, masked: np.ndarray, evidence: Evidence
) -> tuple[np.ndarray, np.ndarray]:
    """Normal matrix (q, q) and right side (q,) of the columns on other readings and motion.

    masked: (n, 6) bool, readings that are not used. Blocks are as long as those of the fit.
    """
    fit = evidence.fit
    blocks = block_means(full, fit.blocks.rate, masked, fewest=1)
    columns, _ = fitted_columns(fit.model, evidence.groups, blocks.motion)
    return equations_of(columns, blocks.readings, blocks, fit.noises).normal()[:2]
