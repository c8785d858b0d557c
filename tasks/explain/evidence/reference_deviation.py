"""Where the standard's parameters are not those of a reference prediction."""

import numpy as np
from scipy.special import chdtrc

from schemas.discrepancy import FoundParameter
from tasks.explain.channels import EVERY
from tasks.explain.explanation import UNNAMED, Finding
from tasks.explain.inputs.full_rate import FullRate
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.stepwise import FALSE_ALARMS
from tasks.explain.whitening import equations_of
from tasks.model.model import Model
from tasks.model.term import places
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.words import message

CLEAR = 3.0  # standard uncertainties from which on a parameter is listed
OTHER = message("explain-other-parameters")


def reference_deviation(
    standard: Model, predicted: np.ndarray, full: FullRate, fit: FittedSelection
) -> list[Finding]:
    """The finding that the standard's parameters are not those of the prediction; none: they are.

    standard: the standard's model fitted to the readings less what the prediction has beyond an
    ideal unit. predicted: (n, 6) by it at full rate.
    """
    ideal = Model.of(STANDARD_TERMS)
    count = int(standard.free.sum())
    gain = _chi2(ideal, fit) - _chi2(standard, fit)
    if chdtrc(count, max(gain, 0.0)) > FALSE_ALARMS:
        return []
    return [
        Finding(
            effect=UNNAMED,
            family=UNNAMED,
            title=OTHER,
            equation="models (1) and (2)",
            source="JJF 2003-2022, 5.1 and 5.2",
            channels=EVERY,
            parameters=_clear_deviations(standard, ideal.values),
            contribution=predicted - ideal.prediction(full.motion),
            gain=gain,
            delta_bic=gain - count * float(np.log(fit.blocks.used)),
            held_out_gain=0.5 * gain - count,
        )
    ]


def _chi2(model: Model, fit: FittedSelection) -> float:
    """Of a model on the blocks that the selection is fitted to."""
    blocks = fit.blocks
    misfit = blocks.readings - model.prediction(blocks.motion)
    return equations_of([], misfit, blocks, fit.noises).normal()[2]


def _clear_deviations(standard: Model, ideal: np.ndarray) -> tuple[FoundParameter, ...]:
    """The parameters that clearly deviate, as differences from the prediction's, SI."""
    found = []
    for term, place in zip(STANDARD_TERMS, places(STANDARD_TERMS), strict=True):
        for p, parameter in enumerate(term.parameters, place.start):
            name, u = f"{term.name}_{parameter.name}", float(standard.u[p])
            change = float(standard.values[p] - ideal[p])
            if u > 0 and abs(change) > CLEAR * u:
                unit = "1" if parameter.factor == 1.0 and parameter.unit == "1" else "SI"
                found.append(FoundParameter(name=name, value=change, unit=unit, u=u))
    return tuple(found)
