"""The standard uncertainty of corrected readings, from the covariance of the calibration.

Of models (1) and (2) an error of the parameters leaves, in what is corrected by them,

    δf = −K_a⁻¹·(δK_a·f + δB_a + δP·ω²),  δω = −K_g⁻¹·(δK_g·ω + δB_g + δG·f + G·δf):

for each channel a sum over 1, ω, f and ω² with coefficients that are linear in the parameters. Its
variance is a quadratic form in these ten numbers, constant for the calibration. What δω does to
P·ω² is left out: of a unit with P = 1 cm at 300 °/s a tenth of the least that K_a leaves.
"""

from dataclasses import dataclass

import numpy as np

from schemas.calibration import Calibration
from schemas.recording import AXES
from tasks.coefficients.correct import Coefficients, local_gravity
from tasks.coefficients.parameters import parameter_covariance
from tasks.model.term import places
from tasks.model.terms.standard import GYRO_G_SENSITIVITY, STANDARD_TERMS
from tasks.segments.summarise import CHANNELS

ONE, RATE, FORCE, SQUARED = 0, 1, 4, 7  # first places among 1, ω, f, ω²
FEATURES = 10
# Where each term stands: first channel, and the first of what it multiplies.
TERMS = {
    "gyro_matrix": (0, RATE), "gyro_bias": (0, ONE), "gyro_g_sensitivity": (0, FORCE),
    "accel_matrix": (3, FORCE), "accel_bias": (3, ONE), "accel_rate_sensitivity": (3, SQUARED),
}  # fmt: skip
AT_ONCE = 1 << 12  # rows: what is made of them stays in the processor's cache


@dataclass(frozen=True)
class ReadingUncertainty:
    """The variance of each corrected channel as a quadratic form in (1, ω, f, ω²), SI.

    forms: (6, 10, 10); NaN for a channel of which a parameter has no uncertainty.
    """

    forms: np.ndarray

    @property
    def unknown(self) -> tuple[str, ...]:
        """The channels of which the calibration does not give it."""
        known = np.isfinite(self.forms).all(axis=(1, 2))
        return tuple(name for name, is_known in zip(CHANNELS, known, strict=True) if not is_known)

    def of_rows(self, rate: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Standard uncertainties (n, 6) of corrected rates and forces (n, 3), rad/s and m/s².

        The errors are those of the calibration: common to all rows, and the readings' own noise is
        not in them.
        """
        u = np.empty((len(rate), len(CHANNELS)))
        for begin in range(0, len(rate), AT_ONCE):
            rows = slice(begin, begin + AT_ONCE)
            basis = _basis(rate[rows], force[rows])
            for channel, form in enumerate(self.forms):
                u[rows, channel] = np.einsum("nf,nf->n", basis @ form, basis)
        return np.asarray(np.sqrt(np.maximum(u, 0.0, out=u), out=u))

    def rms(self, rate: np.ndarray, force: np.ndarray) -> dict[str, float]:
        """Root mean square of `of_rows` for each channel that has it, without making the rows."""
        moment, count = np.zeros((FEATURES, FEATURES)), 0
        for begin in range(0, len(rate), AT_ONCE):
            basis = _basis(rate[begin : begin + AT_ONCE], force[begin : begin + AT_ONCE])
            basis = basis[np.isfinite(basis).all(axis=1)]
            moment += basis.T @ basis
            count += len(basis)
        mean = np.sqrt(np.maximum((self.forms * moment).sum(axis=(1, 2)) / max(count, 1), 0.0))
        every = dict(zip(CHANNELS, mean.tolist(), strict=True))
        return {name: u for name, u in every.items() if name not in self.unknown}


def reading_uncertainty(calibration: Calibration, known: Coefficients) -> ReadingUncertainty | None:
    """How well readings are corrected by a calibration; None where it has no covariance."""
    covariance = parameter_covariance(calibration)
    if covariance is None:
        return None
    per_g = 1.0 / local_gravity(calibration)
    design = np.zeros((len(CHANNELS), FEATURES, len(covariance)))
    for term, place in zip(STANDARD_TERMS, places(STANDARD_TERMS), strict=True):
        channel, feature = TERMS[term.name]
        for number, parameter in enumerate(term.parameters, start=place.start):
            reads, *of = (AXES.index(axis) for axis in parameter.name)
            weight = per_g if term is GYRO_G_SENSITIVITY else 1.0
            design[channel + reads, feature + (of[0] if of else 0), number] = weight
    has_none = np.isnan(np.diag(covariance))
    unknown = (design[:, :, has_none] != 0.0).any(axis=(1, 2))
    weights = np.tensordot(_solved(known), design, axes=1)
    forms = weights @ np.nan_to_num(covariance) @ weights.swapaxes(1, 2)
    forms[unknown] = np.nan
    return ReadingUncertainty(forms)


def _solved(known: Coefficients) -> np.ndarray:
    """(6, 6): corrected rates and forces per what is wrong with both sums that are taken off."""
    by_gyro, by_accel = np.linalg.inv(known.gyro_matrix), np.linalg.inv(known.accel_matrix)
    through = -by_gyro @ known.gyro_g_sensitivity @ by_accel
    return -np.block([[by_gyro, through], [np.zeros((3, 3)), by_accel]])


def _basis(rate: np.ndarray, force: np.ndarray) -> np.ndarray:
    """1, ω, f and ω² (n, 10)."""
    return np.hstack([np.ones((len(rate), 1)), rate, force, rate**2])
