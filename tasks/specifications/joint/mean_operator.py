"""The parameters of the joint method as linear combinations of all segment means."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.recording import AXES
from tasks.model.parameters import ACCEL_FIRST, own
from tasks.model.simulate import CHANNEL_COUNT
from tasks.model.term import Column, Term
from tasks.model.terms.standard import (
    GYRO_BIAS,
    GYRO_G_SENSITIVITY,
    GYRO_MATRIX,
    STANDARD_TERMS,
)
from tasks.specifications.joint.segment_motion import SegmentMotion
from tasks.specifications.joint.zero_correction import Role, zero_corrected
from tasks.specifications.linear import BirgeRatio

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
