"""The standard's parameters beside those of a reference prediction: which of them differ."""

from collections.abc import Sequence

import numpy as np
from scipy.special import chdtrc

from schemas.discrepancy import FoundParameter
from tasks.explain.explanation import Finding
from tasks.explain.inputs.observed import FullRate, Observed
from tasks.explain.regression.equations import equations_of
from tasks.explain.regression.spectrum import Noise
from tasks.explain.search.empirical_terms import UNNAMED
from tasks.explain.search.refit import Model
from tasks.explain.search.stepwise import FALSE_ALARMS
from tasks.model.simulate import predict
from tasks.model.term import nominal_values, parameters_of, places
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.words import message

CLEAR = 3.0  # standard uncertainties from which on a parameter is listed
OTHER = message("explain-other-parameters")


def other_parameters(
    standard: Model, full: FullRate, fine: Observed, noises: Sequence[Noise]
) -> Finding | None:
    """The finding that the standard's parameters are not those of the prediction; None: they are.

    standard: the standard's model fitted to the readings less what was told beyond an ideal unit.
    """
    ideal = nominal_values(STANDARD_TERMS)
    fits = [
        equations_of([], fine.readings - predict(STANDARD_TERMS, fine.motion, values), fine, noises)
        for values in (ideal, standard.values)
    ]
    before, after = (sum(float(gram[-1, -1]) for gram in fit.grams) for fit in fits)
    count = int(standard.free.sum())
    if chdtrc(count, max(before - after, 0.0)) > FALSE_ALARMS:
        return None
    readings = [predict(STANDARD_TERMS, full.motion, each) for each in (standard.values, ideal)]
    return Finding(
        effect=UNNAMED,
        family=UNNAMED,
        title=OTHER,
        equation="models (1) and (2)",
        source="JJF 2003-2022, 5.1 and 5.2",
        channels=tuple(range(6)),
        parameters=_clear(standard, ideal),
        contribution=readings[0] - readings[1],
        gain=before - after,
        delta_bic=before - after - count * float(np.log((fine.weight > 0).sum())),
        held_out_gain=0.5 * (before - after) - count,
        follows=OTHER,
    )


def _clear(standard: Model, ideal: np.ndarray) -> tuple[FoundParameter, ...]:
    """The parameters that are clearly not those told, as differences from them, SI."""
    u = np.sqrt(np.maximum(np.diag(standard.covariance), 0.0))
    found = []
    for term, place in zip(STANDARD_TERMS, places(STANDARD_TERMS), strict=True):
        for n, parameter in enumerate(parameters_of((term,)), start=place.start):
            change = float(standard.values[n] - ideal[n])
            if u[n] > 0 and abs(change) > CLEAR * u[n]:
                unit = "1" if parameter.factor == 1.0 and parameter.unit == "1" else "SI"
                found.append(
                    FoundParameter(
                        name=f"{term.name}_{parameter.name}", value=change, unit=unit, u=float(u[n])
                    )
                )
    return tuple(found)
