"""The joint fit of a unit on a table: every parameter with the lines of its budget.

The unit's model is a list of terms; a term appended to it is fitted with the rest.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from schemas.recording import AXES
from schemas.text import Remark
from tasks.model.model import CHANNEL_COUNT, linearise, predict
from tasks.model.term import ACCEL_FIRST, Column, Term, nominal_values, own, places
from tasks.model.terms.site import earth_rotation
from tasks.model.terms.standard import (
    GYRO_BIAS,
    GYRO_G_SENSITIVITY,
    GYRO_MATRIX,
    STANDARD_TERMS,
)
from tasks.motion.whole import Motion
from tasks.specifications.course import course_remarks, with_course
from tasks.specifications.equipment_errors import (
    EquipmentErrors,
    equipment_errors,
    level_covariance,
)
from tasks.specifications.estimate import (
    UNDETERMINED,
    Estimate,
    Estimates,
    linear_estimate,
)
from tasks.specifications.evidence import (
    RANK_TOLERANCE,
    BirgeRatio,
    ClauseEvidence,
    EarthRotationGain,
    Solution,
    birge_ratio,
    solve,
)
from tasks.specifications.jjf2003.positions import is_paired
from tasks.specifications.unit_model import mean_motion
from tasks.uncertainty.budget import Contribution, observed
from tasks.uncertainty.equipment import Equipment

# The two steps of the joint method, as operators on the segment means.
#
# Step 1: least squares on the simplified model (scale factor times installation error, and bias)
# over all dynamic and static samples, weighted by the inverse of their covariance: what drifts
# together counts less than its number of samples. The simplified model K_i·(ω_i + ε_ij·ω_j) + B_i
# is linear in K_ij = K_i·ε_ij, and the smallest sum of squares is the same in either form, so the
# non-linear problem is solved exactly. Step 2, the zero correction: bias and g-sensitivity of the
# theoretical model from the rests, with step 1 put in; then step 1 again with the g-sensitivity
# taken off. At rest nothing turns, so that step 2 does not feel step 1 but through Earth's
# rotation, which the caller takes off round by round until nothing changes. Terms beyond the
# standard's are fitted in both steps.
#
# An operator is kept, and not only its values: each uncertainty of the equipment goes through it.

QUIETEST = 0.1  # of the median variance
TINY = 1e-9  # of a variance: keeps a covariance that drift or tilt alone makes invertible
Role = Literal["dynamic", "bias", "g-sensitivity", "further"]


@dataclass(frozen=True)
class Solved:
    """Parameters as combinations of the means.

    operator: (p, n), NaN rows for parameters that the segments do not determine.
    excess: for each parameter, how much more its samples scatter than their noise.
    """

    operator: np.ndarray
    excess: tuple[BirgeRatio, ...]


def least_squares(
    design: np.ndarray, used: np.ndarray, means: np.ndarray, covariance: np.ndarray
) -> Solved:
    """Means fitted over the used segments, by generalised least squares.

    design: (n, p); used: (n,) bool; means: (n,); covariance: (n, n) of the means by noise and by
    what the equipment does to each.
    """
    operator = np.zeros((design.shape[1], len(used)))
    if not used.any():
        return Solved(operator * np.nan, (BirgeRatio(),) * design.shape[1])
    block = covariance[np.ix_(used, used)]
    solution = _generalised(design[used], block)
    excess = birge_ratio(solution, design[used], means[used], block)
    operator[:, used] = solution.operator
    operator[~solution.estimable] = np.nan
    return Solved(operator, (excess,) * design.shape[1])


def zero_corrected(
    design: np.ndarray,
    roles: tuple[Role, ...],
    used: np.ndarray,
    zero: np.ndarray,
    means: np.ndarray,
    covariance: np.ndarray,
) -> Solved:
    """Both steps for means (n,); design: (n, p), its columns with their roles.

    used: (n,) bool, the dynamic and static segments; zero: (n,) bool, the rests of step 2, where
    bias and g-sensitivity are estimated beside the further columns. If no rest determines the
    g-sensitivity it is not subtracted, and the bias is not determined. Without a column to correct,
    step 1 is all.
    """
    role = np.array(roles)
    rest, g = np.isin(role, ("bias", "g-sensitivity", "further")), role == "g-sensitivity"
    corrected = rest & (role != "further")
    if not corrected.any():
        return least_squares(design, used, means, covariance)
    at_rest = least_squares(design[:, rest], zero, means, covariance)
    operator = np.full(design.T.shape, np.nan)
    operator[rest] = at_rest.operator
    # A reading with what gravity does to it taken off.
    reduced = np.eye(len(means)) - design[:, g] @ np.nan_to_num(operator[g])
    spread = reduced @ covariance @ reduced.T
    first = least_squares(design[:, ~g], used, reduced @ np.nan_to_num(means), spread)
    by_all = np.full(design.T.shape, np.nan)
    by_all[~g] = first.operator @ reduced
    operator[~corrected] = by_all[~corrected]
    excess = BirgeRatio()
    if used.any():
        undetermined = g & ~np.isfinite(operator).all(axis=1)
        # Where no rest gives the bias, residuals are about that of step 1.
        whole = np.where(np.isfinite(operator).all(axis=1)[:, None], operator, by_all)
        solution = Solution(np.nan_to_num(whole[:, used]), np.ones(len(role), bool))
        block = covariance[np.ix_(used, used)]
        shown = np.where(undetermined, 0.0, design)[used]
        excess = birge_ratio(solution, shown, means[used], block)
    ratios = np.full(len(role), excess, dtype=object)
    ratios[corrected] = at_rest.excess[0]
    return Solved(operator, tuple(ratios))


def _generalised(design: np.ndarray, covariance: np.ndarray) -> Solution:
    """Least squares in the norm of the covariance (n, n).

    No mean counts as if its variance were below a tenth of the usual one: a channel that stood
    still is not the truth.
    """
    variance = np.diag(covariance)
    floor = QUIETEST * np.median(variance) or 1.0
    raised = np.maximum(variance, floor)
    root = np.linalg.cholesky(covariance + np.diag(raised - variance + TINY * raised))
    basis, estimable = _determined(design)
    whitened = solve(np.linalg.solve(root, design @ basis))
    operator = basis @ np.linalg.solve(root.T, whitened.operator.T).T
    return Solution(operator, estimable)


def _determined(design: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Combinations (p, r) of parameters that a design (n, p) determines; (p,) bool, which alone.

    Of the design itself: whitening by a nearly singular covariance loses the digits.
    """
    scale = np.linalg.norm(design, axis=0)
    scale[scale == 0] = 1.0
    _, sizes, rows = np.linalg.svd(design / scale, full_matrices=False)
    kept = rows[sizes > RANK_TOLERANCE * sizes.max(initial=0.0)]
    if len(kept) == design.shape[1]:
        return np.eye(len(kept)), np.ones(len(kept), bool)
    return kept.T / scale[:, None], np.abs((kept**2).sum(axis=0) - 1.0) < 1e-6


# The motion of the unit in each segment, for the joint method.
#
# A segment held at one attitude or rate has one mean reading and one mean motion: fitting the
# means by their covariance is fitting all samples at once.


@dataclass(frozen=True)
class SegmentMotion:
    """The mean motion of the segments, and what each may be used for.

    mean: (n segments); a turn about the vertical has no mean north, which averages out.
    gyro, accel: (n,) bool, what may be fitted to each triad.
    alive: (6,) bool, channels that do not read one and the same number throughout.
    turned: (3,) bool, axes about which the gyro was recorded at two or more rates, or in a turn.
    zero: (n,) bool, the rests that correct gyro bias and g-sensitivity.
    level_unknown: (n,) bool, rests in which the horizontal part of Earth's rotation is not known.
    """

    mean: Motion
    gyro: np.ndarray
    accel: np.ndarray
    alive: np.ndarray
    turned: np.ndarray
    zero: np.ndarray
    level_unknown: np.ndarray

    def used(self, channel: int) -> np.ndarray:
        """(n,) bool: the segments that step 1 fits to a channel, 0 to 5."""
        triad = self.gyro if channel < len(AXES) else self.accel
        return triad & self.alive[channel]

    def zero_corrects(self, channel: int) -> np.ndarray:
        """(n,) bool: the rests that correct a channel's zero; none for an accelerometer."""
        return self.zero & (channel < len(AXES)) & self.alive[channel]


def segment_motion(evidence: ClauseEvidence) -> SegmentMotion:
    """The segments of a recording as the joint method takes them.

    Rests and rates that labels and witnesses contradict are taken as `gather` took them: the axis
    up by gravity, the rate by the encoders, or left out.
    """
    segments = evidence.segments
    motion, vertical = mean_motion(evidence)
    kind = np.array([label.kind for label in evidence.labels], str)
    still, turning = kind == "static", kind == "rate"
    steps = np.array([segment.step for segment in segments]).reshape(-1, 6)
    moved = np.isfinite(motion.rate).all(axis=1)
    gyro = np.array([segment.has_gyro for segment in segments], bool)
    accel = np.array([segment.has_accel for segment in segments], bool)
    turned, alone = _turned_by_gyro(evidence, motion, gyro & moved)
    unknown = still & vertical & ~np.isfinite(motion.north).all(axis=1)
    return SegmentMotion(
        mean=motion,
        gyro=gyro & moved & (vertical | ~still) & ~alone,
        accel=accel & moved & vertical & (still | turning),
        alive=np.asarray((steps > 0.0).any(axis=0)),
        turned=turned,
        zero=gyro & still & vertical & ~_beside_pairs(evidence, unknown),
        level_unknown=unknown & ~_paired(evidence),
    )


def _turned_by_gyro(
    evidence: ClauseEvidence, motion: Motion, read: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(3,) bool, axes that the gyro read turning, and (n,) bool, the runs about the others.

    A turn by a known angle will do, or runs at two rates: one rate is no line, and what it reads
    must not be laid upon the other axes. read: (n,) bool.
    """
    turned, alone = np.zeros(3, bool), np.zeros(len(read), bool)
    for j, axis in enumerate(AXES):
        runs = [i for i in (*evidence.points[axis], *evidence.turns[axis]) if read[i]]
        rates = set(np.round(np.degrees(motion.rate[runs, j]), 1))
        turned[j] = len(rates) > 1 or any(i in runs for i in evidence.turns[axis])
        alone[runs] = not turned[j]
    return turned, alone


def _paired(evidence: ClauseEvidence) -> np.ndarray:
    """(n,) bool: rests of a position that was held at two headings 180° apart."""
    paired = [indices for indices in evidence.positions.values() if is_paired(evidence, indices)]
    return np.isin(np.arange(len(evidence.segments)), np.concatenate([np.zeros(0), *paired]))


def _beside_pairs(evidence: ClauseEvidence, unknown: np.ndarray) -> np.ndarray:
    """(n,) bool: rests of unknown heading with an axis up that was also held as a pair.

    The pair cancels the horizontal part of Earth's rotation; such a rest would bring it back.
    """
    faces = [up for up, indices in evidence.positions.items() if is_paired(evidence, indices)]
    of_such = np.array([up in faces for up in evidence.up], bool)
    return unknown & of_such & ~_paired(evidence)


# The parameters of the joint method as linear combinations of all segment means.

ROLES: dict[str, Role] = {GYRO_BIAS.name: "bias", GYRO_G_SENSITIVITY.name: "g-sensitivity"}


@dataclass(frozen=True)
class Operator:
    """All p parameters as combinations of the segment means of all channels.

    weights: (p, 6, n), NaN where the segments do not determine a parameter; excess: (p,).
    """

    weights: np.ndarray
    excess: tuple[BirgeRatio, ...]

    def values(self, means: np.ndarray, ideal: np.ndarray) -> np.ndarray:
        """(p,) of means (n, 6); as an ideal unit has them where not determined."""
        values = np.einsum("pcn,nc->p", self.weights, np.nan_to_num(means))
        return np.where(np.isfinite(values), values, ideal)


def operator_of(
    terms: tuple[Term, ...],
    columns: Sequence[Column],
    motion: SegmentMotion,
    means: np.ndarray,
    covariances: np.ndarray,
) -> Operator:
    """Both steps over all channels; those that share a parameter are solved together."""
    from scipy.linalg import block_diag  # late: of the joint method alone

    mean = motion.mean
    own_axis = own(ACCEL_FIRST, mean.rate**2)  # fitted beside the model: see `_roles`
    every = [_regressor(column) for column in (*columns, *own_axis)]
    roles = _roles(terms) + ["dynamic"] * len(own_axis)
    for p, unturned in enumerate(_about_unturned(terms, motion)):
        every[p] = {} if unturned else every[p]
    weights = np.zeros((len(columns), CHANNEL_COUNT, len(means)))
    excess = [BirgeRatio()] * len(columns)
    weights[[p for p in range(len(columns)) if not every[p]]] = np.nan
    for group in _groups(every):
        chosen = [p for p, column in enumerate(every) if group & column.keys()]
        if not chosen:
            continue
        channels = sorted(group)
        design = np.column_stack([
            np.concatenate([every[p].get(c, np.zeros(len(means))) for c in channels])
            for p in chosen
        ])  # fmt: skip
        solved = zero_corrected(
            design, tuple(roles[p] for p in chosen),
            np.concatenate([motion.used(c) for c in channels]),
            np.concatenate([motion.zero_corrects(c) for c in channels]),
            means[:, channels].T.ravel(), block_diag(*covariances[channels]),
        )  # fmt: skip
        for p, row, ratio in zip(chosen, solved.operator, solved.excess, strict=True):
            if p < len(columns):
                weights[p, channels], excess[p] = row.reshape(len(channels), -1), ratio
    return Operator(weights, tuple(excess))


def _regressor(column: Column) -> dict[int, np.ndarray]:
    """The channels that a column moves at all, zero where its motion is not known."""
    filled = ((channel, np.nan_to_num(signal)) for channel, signal in column.items())
    return {channel: signal for channel, signal in filled if signal.any()}


def _roles(terms: tuple[Term, ...]) -> list[Role]:
    """For each parameter its part in the two steps.

    Beside the model each accelerometer has a column of its own rate squared: turning about its
    own axis, a misaligned sensor off the centre feels K_ij·r_j·ω_i².
    """
    standard = {term.name for term in STANDARD_TERMS}
    return [
        ROLES.get(term.name, "dynamic" if term.name in standard else "further")
        for term in terms
        for _ in term.parameters
    ]


def _about_unturned(terms: tuple[Term, ...], motion: SegmentMotion) -> list[bool]:
    """For each parameter whether it is of the gyro's matrix, about an axis not read turning."""
    unturned = {axis for axis, turned in zip(AXES, motion.turned, strict=True) if not turned}
    return [
        term.name == GYRO_MATRIX.name and parameter.name[1] in unturned
        for term in terms
        for parameter in term.parameters
    ]


def _groups(columns: Sequence[Column]) -> list[set[int]]:
    """Channels that share a parameter, the others alone."""
    groups = [{channel} for channel in range(CHANNEL_COUNT)]
    for column in columns:
        joined = [group for group in groups if group & column.keys()]
        if len(joined) > 1:
            apart = [group for group in groups if group not in joined]
            groups = [*apart, set().union(*joined)]
    return groups


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
