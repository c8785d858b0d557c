"""Whether accelerometers that lag are filtered, or sit on a mount that swings.

Well below its corner a low-pass that lags by T changes its input f by −T·ḟ + b·f̈ with b between
T²/2 (a delay) and T² (one pole), and the model has that. A mount lags by its damping, and is off by
the square of its period: by −f̈/ω₀² below its resonance, and by the whole of f above.
"""

from collections.abc import Sequence

import numpy as np

from tasks.explain.channels import ACCELS
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.explanation import Refusal
from tasks.explain.whitening import equations_of
from tasks.model.regression import inverse
from tasks.model.term import Inputs, Parameter
from tasks.model.terms.electronics import BANDWIDTH
from tasks.motion.whole import Motion

OF_ACCELEROMETERS = ("accel_time_constant", "accel_lag")
CLEAR = 3.0  # standard uncertainties
MORE = 2.0  # times the square of the lag: more than any order of filter differs by


def swings(
    evidence: Evidence, number: int, parameters: Sequence[Parameter], values: np.ndarray,
    u: np.ndarray,
) -> Refusal | None:  # fmt: skip
    """A low-pass of the accelerometers alone whose amplitude is not that of a filter.

    parameters, values, u: (k,) of the finding.
    """
    group = evidence.groups[number]
    lags = [
        value
        for parameter, value, own in zip(parameters, values.tolist(), u.tolist(), strict=True)
        if parameter.name in OF_ACCELEROMETERS or abs(value) > CLEAR * own
    ]
    alone = [parameter.name in OF_ACCELEROMETERS for parameter in parameters]
    if group.name != BANDWIDTH.name or not any(alone) or len(lags) > sum(alone):
        return None
    curvature, own = _curvature(evidence)
    if abs(curvature) < max(CLEAR * own, MORE * max(lags) ** 2):
        return None
    return Refusal("swings", group.name)


def _curvature(evidence: Evidence) -> tuple[float, float]:
    """Coefficient c of the second derivative of the specific force in the accelerometers beside
    everything else, and its standard uncertainty; s².
    """
    fit = evidence.fit
    model, blocks = fit.model, fit.blocks
    design = model.linearised(blocks.motion, model.free)
    columns = [design.columns[p] for p in np.flatnonzero(model.free)]
    second = _second_derivative(blocks.motion)
    columns.append({channel: second[:, channel - ACCELS[0]] for channel in ACCELS})
    misfit = blocks.readings - design.prediction
    normal, right, chi2 = equations_of(columns, misfit, blocks, fit.noises).normal()
    covariance = inverse(normal)
    dispersion = max(1.0, chi2 / evidence.used)
    return float((covariance @ right)[-1]), float(np.sqrt(dispersion * covariance[-1, -1]))


def _second_derivative(motion: Motion) -> np.ndarray:
    """(n, 3) of the specific force, m/s⁴; zero where it is not known."""
    force = Inputs.of(motion).force
    slope = np.gradient(force, motion.t, axis=0)
    return np.nan_to_num(np.gradient(slope, motion.t, axis=0))
