"""Gauss-Newton iteration for any list of terms and any noise model.

It is our own, and no optimiser of a library, for three reasons. A step ends where it no longer
matters beside the standard uncertainty, which a library that knows no covariance cannot tell:
`scipy.optimize.least_squares` goes on to the last digit, at four to six linearisations of a whole
recording more; and between two linearisations steps go on with the same columns, each at the cost
of one prediction, as long as chi-squared falls (chord method; Kelley, Iterative Methods for Linear
and Nonlinear Equations, SIAM 1995, 5.4.1). A continuous shape (a time constant) is differentiated
by the model only where its term has a size at all, so that the number of columns changes on the
way. And a parameter that would become negative where no unit has it so (a time constant, a filter's
corner) is held at zero, where the others' step is solved again. Fits without terms (`gravity_fit`,
`moves` of the joint method) use scipy's.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tasks.model.model import Model
from tasks.model.regression import Scores, Whiten, inverse
from tasks.model.term import Column
from tasks.motion.whole import Motion

MAX_CHORDS = 4  # steps with the same columns: of more the columns are too old


@dataclass(frozen=True)
class Step:
    """A step (q,) of the free parameters, then the shapes.

    covariance: (q, q) as white noise has it. gain: chi-squared that the step promises.
    misfit: chi-squared from where it sets out, what is known beforehand included.
    columns: by which the parameters were linearised.
    """

    change: np.ndarray
    covariance: np.ndarray
    gain: float
    misfit: float
    columns: Sequence[Column]

    @property
    def u(self) -> np.ndarray:
        """(q,) standard uncertainties."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


def _step(model: Model, motion: Motion, readings: np.ndarray, whiten: Whiten) -> Step:
    """The step from where a model stands; readings: (n, 6) rad/s and m/s²."""
    design = model.design(motion)
    normal, right, chi2 = whiten(design.columns, readings - design.prediction).normal()
    prior = _prior(model, len(normal))
    covariance = inverse(normal + np.diag(prior))
    return _promised(model, design.columns, covariance, right, chi2)


def _chord(
    model: Model, before: Step, motion: Motion, readings: np.ndarray, scores: Scores
) -> Step:
    """A step from the present model with the columns and the covariance of an earlier one."""
    right, chi2 = scores(before.columns, readings - model.prediction(motion))
    return _promised(model, before.columns, before.covariance, right, chi2)


def _promised(
    model: Model, columns: Sequence[Column], covariance: np.ndarray, right: np.ndarray, chi2: float
) -> Step:
    """What a right side (q,) promises, beside what is known of the parameters beforehand."""
    values, prior = model.values[model.free], _prior(model, len(right))
    pull = right.copy()
    pull[: len(values)] -= prior[: len(values)] * values
    change = covariance @ pull
    chi2 += float(prior[: len(values)] @ values**2)
    return Step(change, covariance, float(change @ pull), chi2, columns)


def _prior(model: Model, count: int) -> np.ndarray:
    """(count,) precision beforehand of the free parameters; of the shapes none."""
    prior = np.zeros(count)
    known = model.prior[model.free]
    prior[: len(known)] = known
    return prior


def gauss_newton(
    model: Model,
    motion: Motion,
    readings: np.ndarray,
    whiten: Whiten,
    settled: Callable[[Model, Step], bool],
    max_steps: int,
    scores: Scores | None = None,
) -> tuple[Model, bool]:
    """The model with its free parameters and continuous shapes fitted, and whether it settled.

    max_steps: linearisations. scores: by which steps go on between them, and are shortened where
    they overshoot; without, every step is taken whole.
    """
    for _ in range(max_steps):
        model, end = _iterated(model, motion, readings, whiten, settled, scores)
        if end is not None:
            return model, end
    return model, False


def _iterated(
    model: Model,
    motion: Motion,
    readings: np.ndarray,
    whiten: Whiten,
    settled: Callable[[Model, Step], bool],
    scores: Scores | None,
) -> tuple[Model, bool | None]:
    """The model after one linearisation, and whether it settled; None if it has to continue.

    The columns, which are large, are released on return: those of the next never coexist with them.
    """
    step = _step(model, motion, readings, whiten)
    stepped = model.stepped(step.change, step.covariance)
    if stepped.negative.any():  # the others' step made up for it: they are solved again
        return model.held_at_zero(stepped.negative), None
    if settled(stepped, step):
        return stepped, True
    if scores is None:
        return stepped, None
    model, fell = _by_chords(model, step, motion, readings, settled, scores)
    if settled(model, replace(step, gain=fell)):  # no step keeps what it promises
        return model, False
    return model, None


def _by_chords(
    model: Model,
    step: Step,
    motion: Motion,
    readings: np.ndarray,
    settled: Callable[[Model, Step], bool],
    scores: Scores,
) -> tuple[Model, float]:
    """The model after a step and others with its columns, and by how much chi-squared fell.

    A step that makes it worse is halved.
    """
    start, least = step.misfit, step.misfit
    model = model.stepped(0.0 * step.change, step.covariance)
    for _ in range(MAX_CHORDS):
        stepped = model.stepped(step.change, step.covariance)
        if stepped.negative.any():
            break
        if len(stepped.fitted_shapes) != len(model.fitted_shapes):
            return stepped, np.inf  # a shape that can be followed only from now on
        ahead = _chord(stepped, step, motion, readings, scores)
        if ahead.misfit >= least:
            step = replace(step, change=0.5 * step.change)
            continue
        model, least, step = stepped, ahead.misfit, ahead
        if settled(model, step):
            break
    return model, start - least
