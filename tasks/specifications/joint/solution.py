"""The joint fit of a unit on a table: every parameter with the lines of its budget.

The unit's model is a list of terms; a term appended to it is fitted with the rest.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import AXES
from schemas.text import Remark
from tasks.model.simulate import CHANNEL_COUNT, linearise, predict
from tasks.model.term import Column, Term, nominal_values, places
from tasks.model.terms.site import earth_rotation
from tasks.model.terms.standard import (
    GYRO_MATRIX,
    STANDARD_TERMS,
)
from tasks.specifications.course import course_remarks, with_course
from tasks.specifications.earth_gain import EarthRotationGain
from tasks.specifications.equipment_errors import equipment_errors
from tasks.specifications.error_sources import EquipmentErrors
from tasks.specifications.estimate import (
    UNDETERMINED,
    Estimate,
    Estimates,
    linear_estimate,
)
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.horizontal_earth import level_covariance
from tasks.specifications.joint.mean_operator import Operator, operator_of
from tasks.specifications.joint.segment_motion import SegmentMotion
from tasks.specifications.linear import BirgeRatio
from tasks.uncertainty.budget import Contribution, observed
from tasks.uncertainty.equipment import Equipment

MAX_ROUNDS = 20  # of the zero correction; Earth's rotation settles in three
SETTLED = 1e-12  # of a parameter, in its own SI unit: nothing changes any more


@dataclass(frozen=True)
class Joint:
    """The result of the joint fit.

    estimates: by term, by parameter, in the term's SI unit. offset: by axis, rad/s, the gyro
    reading at zero rate in the attitude of its rate runs. excess: (6,) for each channel the largest
    factor by which its samples scatter too much. covariance: (6, n, n) of the segment means, by
    whose inverse each channel is weighted. earth: Earth's rotation as shown by the rests; it is not
    subtracted if they refute it. errors: of the equipment. remarks: on the course of the zeros.
    """

    estimates: dict[str, Estimates]
    offset: Estimates
    excess: np.ndarray
    covariance: np.ndarray
    earth: EarthRotationGain | None
    errors: EquipmentErrors
    remarks: tuple[Remark, ...] = ()


def solve_jointly(
    evidence: ClauseEvidence,
    motion: SegmentMotion,
    equipment: Equipment,
    terms: tuple[Term, ...] = STANDARD_TERMS,
) -> Joint:
    """Both steps of the method (`zero_correction`), with Earth's rotation subtracted, to
    convergence.

    The accelerometers need one step: bias, scale factor, cross coupling and rate sensitivity by
    least squares over everything. Scatter is compared with the noise and with the possible
    equipment errors of each segment. Earth's rotation is known except for the scale factor that
    reads it, so it is predicted, subtracted, and predicted again; if the rests refute it, nothing
    is subtracted. Non-linear terms are linearised again in each round.
    """
    latitude = None if evidence.earth and evidence.earth.refuted else evidence.latitude_deg

    def terms_at(off: float) -> tuple[Term, ...]:
        known = () if latitude is None else (earth_rotation(np.radians(latitude) + off),)
        return (*known, *terms)

    values = ideal = nominal_values(terms)
    errors = equipment_errors(evidence, motion.mean, terms_at, ideal, equipment)
    evidence = with_course(evidence, motion.mean, errors)
    by_errors = np.array([errors.covariance(c) for c in range(CHANNEL_COUNT)])
    if not evidence.has_table:  # weights that trust labels on what the means share cancel too much
        by_errors *= np.eye(errors.segments)
    noise = [np.nan_to_num(evidence.covariance(c)) for c in range(CHANNEL_COUNT)]
    covariances = np.array(noise) + by_errors
    for c in range(len(AXES)):
        covariances[c] += level_covariance(evidence, motion.mean, c)
    earth = np.zeros_like(evidence.means)
    for _ in range(MAX_ROUNDS):
        design = linearise(terms, motion.mean, values)
        # What a linear model of these columns would not predict: nothing for the standard's terms.
        curved = design.prediction - _linear(design.columns, values, design.prediction.shape)
        known = earth + np.nan_to_num(curved)
        operator = operator_of(terms, design.columns, motion, evidence.means - known, covariances)
        before, values = values, operator.values(evidence.means - known, ideal)
        if np.abs(values - before).max() < SETTLED:
            break
        with_earth = predict(terms_at(0.0), motion.mean, values)
        earth = np.nan_to_num(with_earth - predict(terms, motion.mean, values))
    reduced = replace(evidence, means=evidence.means - known)
    errors = equipment_errors(evidence, motion.mean, terms_at, values, equipment)
    return Joint(
        estimates=_by_term(terms, [
            _estimate(reduced, weights, excess, errors)
            for weights, excess in zip(operator.weights, operator.excess, strict=True)
        ]),
        offset=_offsets(terms, evidence, motion, operator, errors),
        excess=_largest_excess(operator),
        covariance=covariances,
        earth=evidence.earth,
        remarks=tuple(course_remarks(evidence)),
        errors=errors,
    )  # fmt: skip


def _linear(columns: Sequence[Column], values: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """(n, 6) sum of columns times values."""
    total = np.zeros(shape)
    for value, column in zip(values, columns, strict=True):
        for channel, signal in column.items():
            total[:, channel] += value * signal
    return total


def _largest_excess(operator: Operator) -> np.ndarray:
    factors = np.array([ratio.factor for ratio in operator.excess])
    of_channel = operator.weights.any(axis=2)  # NaN counts: the channel was asked
    return np.where(of_channel, factors[:, None], 1.0).max(axis=0)


def _by_term(terms: tuple[Term, ...], estimates: Sequence[Estimate]) -> dict[str, Estimates]:
    return {
        term.name: dict(zip((p.name for p in term.parameters), estimates[place], strict=True))
        for term, place in zip(terms, places(terms), strict=True)
    }


def _estimate(
    evidence: ClauseEvidence, weights: np.ndarray, excess: BirgeRatio, errors: EquipmentErrors
) -> Estimate:
    """Σ o·U over the channels, with its budget's lines; weights: o (6, n)."""
    if not np.isfinite(weights).all() or not weights.any():
        return UNDETERMINED
    channels = np.flatnonzero(weights.any(axis=1)).tolist()
    parts = [linear_estimate(evidence, c, weights[c], excess) for c in channels]
    lines = parts[0].lines if len(parts) == 1 else (_summed_type_a(parts),)
    value = sum(part.value for part in parts)
    every = (*lines, *errors.lines(weights, without_earth=True))
    return Estimate(value, every, operator=weights, without_earth=True)


def _summed_type_a(parts: Sequence[Estimate]) -> Contribution:
    """What the data of several channels say of their sum, independent of one another."""
    lines = [line for part in parts for line in part.lines]
    u = np.array([line.quantity.u * line.sensitivity for line in lines])
    total = float(np.linalg.norm(u))
    quarters = (u**4 / [line.quantity.dof for line in lines]).sum()  # Welch and Satterthwaite
    return observed(total, "", total**4 / quarters if quarters else np.inf)


def _offsets(
    terms: tuple[Term, ...],
    evidence: ClauseEvidence,
    motion: SegmentMotion,
    operator: Operator,
    errors: EquipmentErrors,
) -> Estimates:
    """Mean of reading less K·rate over the rate points about each axis, its own gyro, rad/s."""
    offsets: Estimates = {}
    names = [(term.name, parameter.name) for term in terms for parameter in term.parameters]
    for i, axis in enumerate(AXES):
        rows = [names.index((GYRO_MATRIX.name, axis + other)) for other in AXES]
        points = [k for k in evidence.points[axis] if motion.gyro[k]]
        mean = np.zeros(len(evidence.segments))
        mean[points] = 1.0 / max(len(points), 1)
        turned = mean @ np.nan_to_num(motion.mean.rate)
        of_k = operator.weights[rows]
        # An axis nobody turned needs no K.
        weights = -np.tensordot(turned, np.where(turned[:, None, None] == 0.0, 0.0, of_k), axes=1)
        weights[i] += mean
        excess = operator.excess[rows[0]]
        offsets[axis] = _estimate(evidence, weights, excess, errors) if points else UNDETERMINED
    return offsets
