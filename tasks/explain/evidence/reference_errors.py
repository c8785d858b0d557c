"""Which findings and values the errors of the reference make by themselves.

What smooths or shrinks the predicted motion, as a low-pass beside a lead or a dead band does, fits
better for that alone: the motion carries the encoder's noise and the unit does not (attenuation by
errors in the regressor; Fuller, Measurement Error Models, 1987). And what follows the ends of moves
fits what smoothing the encoder leaves there. How much either earns, a simulated reading tells.

The filter that keeps the noise of poses or encoders out of their derivatives takes a little of the
motion too, most of it near the end of the band. What it takes follows the motion, so that no
scatter shows it: parameters that follow the same motion make up for it. How much it takes, the
smoothed motion tells when it is smoothed again.

The axes of a unit on a tracked body are those of its gyros, which are not square to each other: how
far they all are turned from those that the unit is said to have, nothing tells.
"""

from dataclasses import replace
from functools import cache

import numpy as np

from schemas.recording import Stream
from tasks.explain.evidence.evidence import Evidence, fitted_columns
from tasks.explain.explanation import UNNAMED
from tasks.explain.inputs.blocks import FullRate
from tasks.explain.inputs.prepared import Prepared
from tasks.explain.inputs.reference import smoothed_motion
from tasks.explain.inputs.simulated_reading import simulated_reading
from tasks.explain.noise import equations_of, scores_of
from tasks.model.fit import inverse
from tasks.model.model import Model
from tasks.model.terms.axes import turned_by
from tasks.model.terms.standard import GYRO_MATRIX
from tasks.motion.encoders import lost_acceleration
from tasks.motion.pose import TrackedMotion, motion_smoothed_twice
from tasks.motion.table import TableAxes
from tasks.motion.whole import Motion

# Of a finding's gain, a third of its size: what errors of the reference may make of it.
REFERENCE_SHARE = 1 / 9
DRAWS = 4  # of those errors: what they bring forth by chance alone differs
SEED = 20
OF_THREE = 1.6  # Student's t of three values over that of many: so few tell how square axes are


def fitted_to_reference_noise(prepared: Prepared, standard: Model, evidence: Evidence) -> set[int]:
    """Numbers of the findings that the errors of the reference would bring forth by themselves;
    without a name none is asked for.

    standard: the model without findings, fitted.
    """
    full = prepared.full
    if all(group.name == UNNAMED for group in evidence.groups):
        return set()
    rng = np.random.default_rng(SEED)
    normal, right = np.zeros(()), np.zeros(())
    owed: set[int] = set()
    for draws in range(1, DRAWS + 1):
        simulated = simulated_reading(prepared.recording, full, rng)
        if simulated is None:
            return set()
        true, read = simulated
        errors = standard.prediction(true) - standard.prediction(read)
        more = _equations_on(replace(full, readings=errors, motion=read), prepared, evidence)
        normal, right = normal + more[0], right + more[1]
        made = _gains(evidence, normal / draws, right / draws).tolist()
        owed = {
            number
            for number, gain in enumerate(made)
            if gain - len(evidence.own[number]) / draws > REFERENCE_SHARE * evidence.gain(number)
        }
        if not owed:
            break
    return owed


def _gains(evidence: Evidence, normal: np.ndarray, right: np.ndarray) -> np.ndarray:
    """What each finding earns beside the others."""
    normal = normal + np.diag(evidence.prior)

    @cache
    def earned(rows: tuple[int, ...]) -> float:
        some = list(rows)
        return float(right[some] @ inverse(normal[np.ix_(some, some)]) @ right[some])

    others = set(range(len(right))) - set(evidence.known.tolist())
    return np.array([
        earned(tuple(sorted(others | set(own)))) - earned(tuple(sorted(others - set(own))))
        for own in map(np.ndarray.tolist, evidence.own)
    ])  # fmt: skip


def with_smoothing_error(evidence: Evidence, prepared: Prepared) -> Evidence:
    """The evidence, with u that covers what smoothing the reference moves its parameters by, and
    the turn of a tracked body's axes.
    """
    if not evidence.groups:
        return evidence
    axes = evidence.fit.blocks.motion.axes
    turned = np.zeros(len(evidence.prior))
    if prepared.full.motion.tracking is not None and prepared.recording.reference is not None:
        normal, right = _lost_of_poses(evidence, prepared, prepared.recording.reference)
        turned = _by_axes(evidence)
    elif axes is not None:
        normal, right = _lost_of_encoders(evidence, prepared, axes)
    else:
        return evidence
    moved = inverse(normal + np.diag(evidence.prior)) @ right
    return replace(evidence, smoothing_error=np.hypot(moved, turned))


def _by_axes(evidence: Evidence) -> np.ndarray:
    """(q,) u of each column's factor by the axes of the gyros: of errors of each of them alike, the
    common turn is as large as half of what two of them are off a right angle.
    """
    fit, motion = evidence.fit, evidence.fit.blocks.motion
    matrix = fit.model.values[fit.model.places[GYRO_MATRIX.key]].reshape(3, 3)
    off = 0.5 * (matrix + matrix.T)[np.triu_indices(3, 1)]
    columns, before = fitted_columns(fit.model, evidence.groups, motion)
    covariance = inverse(evidence.whole.normal()[0] + np.diag(evidence.prior))
    u = np.zeros(len(covariance))
    for axis in np.eye(3):
        turn = OF_THREE * np.sqrt((off**2).mean()) * np.broadcast_to(axis, motion.rate.shape)
        turned = replace(
            turned_by(motion, turn, None, motion.rate),
            acceleration=motion.acceleration - np.cross(turn, motion.acceleration),
        )
        change = np.nan_to_num(fit.model.prediction(turned) - before)
        right, _ = scores_of(columns, change, fit.blocks, fit.noises)
        u = np.hypot(u, covariance @ right)
    return u


def _lost_of_poses(
    evidence: Evidence, prepared: Prepared, pose: Stream
) -> tuple[np.ndarray, np.ndarray]:
    """Normal matrix and right side of the columns on what a second smoothing takes of readings."""
    full = prepared.full
    tracking, t = full.motion.tracking, full.motion.t + full.start
    again: Motion | TrackedMotion = motion_smoothed_twice(prepared.recording, pose, t)
    if tracking is not None and tracking.place is not None:
        again = smoothed_motion(full.motion, pose, t, tracking, twice=True)
    twice = replace(
        full.motion, up=again.up, north=again.north, rate=again.rate,
        translation=again.translation,
    )  # fmt: skip
    model = evidence.fit.model
    lost = model.prediction(full.motion) - model.prediction(twice)
    return _equations_on(replace(full, readings=lost), prepared, evidence)


def _lost_of_encoders(
    evidence: Evidence, prepared: Prepared, axes: TableAxes
) -> tuple[np.ndarray, np.ndarray]:
    """The same of the accelerations that encoders tell, in the blocks of the fit; axes: there."""
    fit, blocks = evidence.fit, evidence.fit.blocks
    motion = blocks.motion
    spun = lost_acceleration(prepared.recording, blocks.t + prepared.full.start)
    change = np.einsum("nk,nki->ni", spun, axes.directions)
    twice = replace(motion, acceleration=motion.acceleration - change)
    lost = fit.model.prediction(motion) - fit.model.prediction(twice)
    columns, _ = fitted_columns(fit.model, evidence.groups, motion)
    right, _ = scores_of(columns, np.nan_to_num(lost), blocks, fit.noises)
    return evidence.whole.normal()[0], right


def _equations_on(
    other: FullRate, prepared: Prepared, evidence: Evidence
) -> tuple[np.ndarray, np.ndarray]:
    """Normal matrix (q, q) and right side (q,) of the columns on other readings and motion, in
    blocks as long as those of the fit.
    """
    fit = evidence.fit
    blocks = prepared.blocks_of_other(other, fit.blocks.rate)
    columns, _ = fitted_columns(fit.model, evidence.groups, blocks.motion)
    return equations_of(columns, blocks.readings, blocks, fit.noises).normal()[:2]
