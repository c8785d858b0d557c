"""The joint fit of a unit on a table: every parameter with its value and its budget's lines."""

from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import AXES
from tasks.model.simulate import Design, linearise, predict
from tasks.model.term import Term, nominal_values, places
from tasks.model.terms.site import earth_rotation
from tasks.model.terms.standard import ACCEL_TERMS, GYRO_TERMS, STANDARD_TERMS
from tasks.specifications.earth_rotation import EarthRotationGain
from tasks.specifications.estimate import UNDETERMINED, Estimate, linear_estimate
from tasks.specifications.evidence import Evidence
from tasks.specifications.joint.equipment import Disturbed, disturbed
from tasks.specifications.joint.north import level_covariance
from tasks.specifications.joint.stretches import Stretches
from tasks.specifications.joint.zero_correction import Solved, least_squares, zero_corrected
from tasks.specifications.linear import BirgeRatio
from tasks.uncertainty.equipment import Equipment

ROUNDS = 20  # of the zero correction; Earth's rotation settles in three
SETTLED = 1e-12  # of a parameter, in its own SI unit: nothing changes any more

Found = dict[str, dict[str, Estimate]]


@dataclass(frozen=True)
class Joint:
    """What the joint fit found.

    found: by term, by parameter (names of `tasks.model.terms.standard`), in the term's SI unit.
    offset: by axis, rad/s, what the gyro reads at no rate in the attitude of its rate runs.
    excess: (6,) for each channel the largest factor by which its samples scatter too much.
    covariance: (6, n, n) of the segment means, by whose inverse each channel was weighed.
    earth: what the rests show of Earth's rotation; where they refute it, it was not taken off.
    """

    found: Found
    offset: dict[str, Estimate]
    excess: np.ndarray
    covariance: np.ndarray
    earth: EarthRotationGain | None


def solve_jointly(evidence: Evidence, taken: Stretches, equipment: Equipment) -> Joint:
    """Both steps of the method (`zero_correction`), with Earth's rotation taken off, to rest.

    The accelerometers need one step: bias, scale factor, cross coupling and rate sensitivity by
    least squares over everything. What scatters is measured against the noise and against what
    the equipment may do to each segment. Earth's rotation is known but for the scale factor that
    reads it, so that it is predicted, taken off, and predicted again; where the rests refute it
    nothing is taken off.
    """
    seen, latitude = evidence.earth, evidence.latitude_deg
    taken_off = None if seen and seen.refuted else latitude

    def terms_at(moved: float) -> tuple[Term, ...]:
        known = () if taken_off is None else (earth_rotation(np.radians(taken_off) + moved),)
        return (*known, *STANDARD_TERMS)

    design = linearise(STANDARD_TERMS, taken.motion, nominal_values(STANDARD_TERMS))
    ideal = nominal_values(STANDARD_TERMS)
    values, earth = ideal, np.zeros_like(evidence.means)
    follows = disturbed(evidence, taken.motion, terms_at, ideal, equipment)
    covariances = [np.nan_to_num(evidence.covariance(c)) + follows.covariance(c) for c in range(6)]
    for c in range(len(AXES)):
        covariances[c] += level_covariance(evidence, taken, c, latitude)
    for _ in range(ROUNDS):
        means = evidence.means - earth
        solved = [
            _channel(taken, design, c, means[:, c], covariance)
            for c, covariance in enumerate(covariances)
        ]
        before, values = values, _values(solved, means, ideal)
        if np.abs(values - before).max() < SETTLED:
            break
        turned = predict(terms_at(0.0), taken.motion, values)
        earth = np.nan_to_num(turned - predict(STANDARD_TERMS, taken.motion, values))
    still = replace(evidence, means=evidence.means - earth)
    follows = disturbed(evidence, taken.motion, terms_at, values, equipment)
    return Joint(
        found=_found(still, solved, follows),
        offset=_offsets(evidence, taken, solved, follows),
        excess=np.array([max(e.factor for e in each.excess) for each in solved]),
        covariance=np.array(covariances),
        earth=seen,
    )


def _channel(
    taken: Stretches, design: Design, channel: int, means: np.ndarray, covariance: np.ndarray
) -> Solved:
    """One channel's parameters, in the order of its terms."""
    columns = np.nan_to_num(design.of_channel(channel)[1])
    if not taken.alive[channel]:
        return Solved(np.full(columns.T.shape, np.nan), (BirgeRatio(),) * columns.shape[1])
    if channel >= len(AXES):
        # Turning about its own axis, a misaligned sensor off the centre feels K_ij·r_j·ω_i².
        own = np.nan_to_num(taken.motion.rate[:, channel - len(AXES), None]) ** 2
        solved = least_squares(np.hstack([columns, own]), taken.accel, means, covariance)
        return Solved(solved.operator[:-1], solved.excess[:-1])
    rates, forces = columns[:, :3] * taken.turned, columns[:, 4:]
    return zero_corrected(rates, forces, taken.gyro, taken.zero, means, covariance)


def _parameters(channel: int) -> tuple[tuple[str, str], ...]:
    """Term and parameter of each row of a channel's operator."""
    axis = AXES[channel % 3]
    terms = GYRO_TERMS if channel < len(AXES) else ACCEL_TERMS
    return tuple(
        (term.name, parameter.name)
        for term in terms
        for parameter in term.parameters
        if parameter.name[0] == axis
    )


def _values(solved: list[Solved], means: np.ndarray, ideal: np.ndarray) -> np.ndarray:
    """All parameters (p,) in the order of the standard terms, ideal where not determined."""
    values = ideal.copy()
    where = {
        (term.name, parameter.name): place.start + i
        for term, place in zip(STANDARD_TERMS, places(STANDARD_TERMS), strict=True)
        for i, parameter in enumerate(term.parameters)
    }
    for channel, each in enumerate(solved):
        found = each.operator @ np.nan_to_num(means[:, channel])
        for key, value in zip(_parameters(channel), found, strict=True):
            if np.isfinite(value):
                values[where[key]] = value
    return values


def _found(evidence: Evidence, solved: list[Solved], follows: Disturbed) -> Found:
    found: Found = {term.name: {} for term in STANDARD_TERMS}
    for channel, each in enumerate(solved):
        rows = zip(_parameters(channel), each.operator, each.excess, strict=True)
        for (term, parameter), weights, excess in rows:
            found[term][parameter] = _element(evidence, channel, weights, excess, follows)
    return found


def _element(
    evidence: Evidence, channel: int, weights: np.ndarray, excess: BirgeRatio, follows: Disturbed
) -> Estimate:
    if not np.isfinite(weights).all() or not weights.any():
        return UNDETERMINED
    seen = linear_estimate(evidence, channel, weights, excess)
    return seen.with_lines(*follows.lines(channel, weights))


def _offsets(
    evidence: Evidence, taken: Stretches, solved: list[Solved], follows: Disturbed
) -> dict[str, Estimate]:
    """Mean of reading less K·rate over the rate points about each axis, its own gyro, rad/s."""
    offsets: dict[str, Estimate] = {}
    for i, axis in enumerate(AXES):
        points = [k for k in evidence.points[axis] if taken.gyro[k]]
        mean = np.zeros(len(evidence.segments))
        mean[points] = 1.0 / max(len(points), 1)
        turned = mean @ np.nan_to_num(taken.motion.rate)
        of_k = solved[i].operator[:3]
        read = np.where(turned[:, None] == 0.0, 0.0, of_k)  # an axis nobody turned needs no K
        weights = mean - turned @ read
        excess = solved[i].excess[0]
        offsets[axis] = _element(evidence, i, weights, excess, follows) if points else UNDETERMINED
    return offsets
