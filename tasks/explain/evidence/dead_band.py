"""Whether a dead band is seen where the unit turns, and not only where it rests.

At rest a dead band takes nothing off; what it seems to take off there is what errs in the rate that
the reference tells of a rest. Of faster rates it takes its whole threshold off.
"""

from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from tasks.explain.evidence.columns import fitted_columns
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.si_units import unit_of
from tasks.explain.explanation import Refusal
from tasks.explain.whitening import equations_of
from tasks.model.regression import inverse
from tasks.model.term import parameters_of
from tasks.model.terms.gyro import THRESHOLD

COVERAGE = 2.0  # standard uncertainties in U
CHANCE = 1e-3  # p value of coefficients that the faster rates show
FAST = 3.0  # thresholds: faster than what the errors of a rest make of it


def unseen_turning(evidence: Evidence, number: int) -> Refusal | None:
    """Where a dead band's coefficients may be nothing by the faster rates alone."""
    fit, group = evidence.fit, evidence.groups[number]
    bands = [term for term in group.terms if THRESHOLD in term.shapes]
    if not bands:
        return None
    threshold = max(band.at[band.shapes.index(THRESHOLD)] for band in bands)
    blocks, model = fit.blocks, fit.model
    columns, prediction = fitted_columns(model, evidence.groups, blocks.motion)
    misfit = blocks.readings - prediction
    reported = np.nan_to_num(blocks.motion.rate)
    felt = reported + np.nan_to_num(misfit[:, :3])  # of a rest whose reference errs: nothing
    fast = np.minimum(np.abs(reported), np.abs(felt)) > FAST * threshold
    turning = replace(blocks, weight=blocks.weight * np.hstack([fast, np.ones_like(fast)]))
    normal, right, _ = equations_of(columns, misfit, turning, fit.noises).normal()
    right = right + normal @ evidence.scatter.values
    covariance = inverse(normal + np.diag(evidence.prior))
    free = np.flatnonzero(model.free)
    places = [p for band in bands for p in range(*model.places[band.key].indices(len(model.free)))]
    own = np.flatnonzero(np.isin(free, places))
    values = (covariance @ right)[own]
    covariance = covariance[np.ix_(own, own)] * evidence.scatter.dispersion(number)
    if chi2.sf(values @ inverse(covariance) @ values, len(own)) < CHANCE:
        return None
    u = np.sqrt(np.diag(covariance))
    k = int((np.abs(values) / u).argmax())
    parameter = parameters_of(model.terms)[free[own[k]]]
    return Refusal(
        "undetermined", group.name, parameter.name, unit_of(parameter),
        float(values[k]), COVERAGE * float(u[k]),
    )  # fmt: skip
