"""Gauss and Newton's iteration for a list of terms, whatever its noise and whichever its terms.

It is our own, and no optimiser of a library, for three reasons. A step ends where it no longer
matters beside the standard uncertainty, which a library that knows no covariance cannot tell:
`scipy.optimize.least_squares` goes on to the last digit, at four to six linearisations of a whole
recording more. A continuous shape (a time constant) is differentiated by the model only where its
term has a size at all, so that the number of columns changes on the way. And a parameter that
would become negative where no unit has it so (a time constant, a filter's corner) is held at zero,
where the others' step is solved again. Fits without terms (`gravity_fit`, `moves` of the joint
method) use scipy's.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tasks.model.model import Model
from tasks.model.regression import Whiten, inverse
from tasks.motion.whole import Motion


@dataclass(frozen=True)
class Step:
    """A step (q,) of the free parameters, then the shapes.

    covariance: (q, q) as white noise has it. gain: chi-squared that the step promises.
    """

    change: np.ndarray
    covariance: np.ndarray
    gain: float

    @property
    def u(self) -> np.ndarray:
        """(q,) standard uncertainties."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


def _step(model: Model, motion: Motion, readings: np.ndarray, whiten: Whiten) -> Step:
    """The step from where a model stands; readings: (n, 6) rad/s and m/s²."""
    design = model.design(motion)
    normal, right, _ = whiten(design.columns, readings - design.prediction).normal()
    rows = np.flatnonzero(model.free)
    prior, pull = np.zeros(len(normal)), np.zeros(len(normal))
    prior[: len(rows)] = model.prior[rows]
    pull[: len(rows)] = model.prior[rows] * model.values[rows]
    covariance = inverse(normal + np.diag(prior))
    change = covariance @ (right - pull)
    return Step(change, covariance, float(change @ (right - pull)))


def gauss_newton(
    model: Model,
    motion: Motion,
    readings: np.ndarray,
    whiten: Whiten,
    settled: Callable[[Model, Step], bool],
    max_steps: int,
) -> tuple[Model, bool]:
    """The model with its free parameters and continuous shapes fitted, and whether it settled."""
    for _ in range(max_steps):
        step = _step(model, motion, readings, whiten)
        stepped = model.stepped(step.change, step.covariance)
        if stepped.negative.any():  # the others' step made up for it: they are solved again
            model = model.held_at_zero(stepped.negative)
            continue
        model = stepped
        if settled(model, step):
            return model, True
    return model, False
