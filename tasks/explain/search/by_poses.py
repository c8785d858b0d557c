"""A selection of a tracked body, fitted as the noise of its poses has it."""

from dataclasses import replace

import numpy as np

from tasks.explain.inputs.blocks import well_known
from tasks.explain.search.design import banded_design, residual_noises
from tasks.explain.search.fitted import NOISE_ROUNDS, FittedSelection

DERIVATIVES = (2, 4)  # powers of frequency by which noise of poses rises in rates and in forces


def fitted_by_poses(fit: FittedSelection) -> FittedSelection:
    """The same fitted once more where poses tell the motion as it was, each frequency by what
    their derivatives' noise leaves there; as it is where the motion is not from poses.

    What is selected stays: as long as something is missing, it lies where the motion is and would
    be taken for noise that does not rise.
    """
    tracking = fit.blocks.motion.tracking
    if tracking is None:
        return fit
    fit = replace(fit, blocks=replace(fit.blocks, band=well_known(tracking)))
    for _ in range(NOISE_ROUNDS):
        model, blocks = fit.model, fit.blocks
        columns = model.design(blocks.motion).columns
        misfit = blocks.readings - model.prediction(blocks.motion)
        design = banded_design(blocks, misfit, columns, np.ones(len(columns)))
        left = residual_noises(design, range(len(columns)), fit.noises, DERIVATIVES)
        factor = fit.search_rate / blocks.rate
        noises = tuple(noise.at_rate(factor) for noise in left)
        fit = fit.reselected(replace(fit.selection, noises=noises))
    return fit
