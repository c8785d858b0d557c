"""A prediction from another source, instead of the standard's model fitted to the recording.

Only what the prediction and an ideal unit differ by is taken off the readings. So the standard's
own parameters, fitted to what is left, are those of an ideal unit where the prediction has them
right, and the search for missing physics is the same.
"""

from dataclasses import dataclass

import numpy as np

from tasks.model.simulate import predict
from tasks.model.term import nominal_values
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.whole import Motion
from tasks.words import Sayable


@dataclass(frozen=True)
class ReferencePrediction:
    """readings: (n, 6) rad/s and m/s² at the unit's rows, NaN where nothing is predicted.

    model: whose prediction it is, for the report.
    """

    readings: np.ndarray
    model: Sayable

    def beyond_ideal(self, motion: Motion) -> np.ndarray:
        """(n, 6) what is predicted less what an ideal unit would read."""
        return self.readings - predict(STANDARD_TERMS, motion, nominal_values(STANDARD_TERMS))
