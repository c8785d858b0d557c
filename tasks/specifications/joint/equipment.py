"""Errors of the equipment propagated through the joint solution (type B).

Each limit changes what the unit went through, and the change of the readings goes through the
operator of the fit: δθ = O·δy. A table angle is wrong by its own amount in every position; a run
of rates and the rests beside it have one setting. Axes that are not square tilt each face of its
own; a fixture is wrong by one amount while the unit stays mounted. The
outermost axis leans from the vertical by as much as angles and axes allow: that shows in rests,
and averages out in turns.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from tasks.model.simulate import predict
from tasks.model.term import Term
from tasks.motion.whole import Motion
from tasks.specifications.evidence import ClauseEvidence
from tasks.uncertainty.budget import Contribution
from tasks.uncertainty.equipment import Equipment, ErrorLimit
from tasks.uncertainty.type_b import MIN_RIPPLE_ANGLE

STEP = 1e-5  # rad, or relative: small beside one, large beside rounding

LEAST_SHARE = 1e-6  # of the largest line of a budget: rounding, not a line of its own


@dataclass(frozen=True)
class EquipmentResponse:
    """How the mean readings follow the equipment's errors, per unit of each.

    tilt: (3, n, 6) per rad about each body axis. lean: (2, n, 6) per rad of the vertical towards
    two headings. rate, gravity: (n, 6) per relative error.
    latitude: (n, 6) per rad.
    settings, faces, mountings: (n,) numbers of the table's settings, of the axes up, and of the
    unit's mountings in its fixture.
    turn_share: (n,) relative error of a turn's rate per rad of its angle; zero where none is
    turned. ripple_share: (n,) rms of what a ripple leaves in the mean rate of a run; zero where
    none is held. time_share: (n,) the same per second by which each angle of a polled encoder is
    off. rate_limits: of each held rate.
    """

    tilt: np.ndarray
    lean: np.ndarray
    rate: np.ndarray
    gravity: np.ndarray
    latitude: np.ndarray
    settings: np.ndarray
    faces: np.ndarray
    mountings: np.ndarray
    turn_share: np.ndarray
    ripple_share: np.ndarray
    time_share: np.ndarray
    rate_limits: Mapping[int, tuple[ErrorLimit, ...]]
    equipment: Equipment
    local_gravity: float

    def lines(self, weights: np.ndarray) -> tuple[Contribution, ...]:
        """The lines of Σ o·U over the channels; weights: o (6, n).

        For errors of the stated rate, gravity and latitude: the true ones act with the opposite
        sign.
        """
        gravity = (weights.T * self.gravity).sum() / self.local_gravity
        latitude = (weights.T * self.latitude).sum()
        rate = (weights.T * self.rate).sum(axis=1)
        every = (
            *self._rates(rate),
            *self._angles(weights, rate),
            Contribution(self.equipment.gravity.quantity, -float(gravity)),
            Contribution(self.equipment.latitude.quantity, -float(latitude)),
        )
        sizes = [abs(line.sensitivity) * line.quantity.u for line in every]
        least = LEAST_SHARE * max(sizes)
        return tuple(line for line, size in zip(every, sizes, strict=True) if size > least)

    def covariance(self, channel: int) -> np.ndarray:
        """Covariance (n, n) of one channel's means by the angle errors that the model cannot
        follow.

        Errors of rate, gravity and latitude change the parameters, not the residuals.
        """
        tilt, lean = self.tilt[:, :, channel], self.lean[:, :, channel]
        leaning, across = lean.T @ lean, tilt.T @ tilt
        total = np.zeros_like(across)
        for limit, groups, leans, share in self._tilts():
            common = across * (groups[:, None] == groups)
            own = np.diag((self.rate[:, channel] * share) ** 2)
            total += limit.u**2 * (common + leans * leaning + own)
        if self.equipment.ripple is not None:
            ripple = self.rate[:, channel] * self.ripple_share
            total += self.equipment.ripple.u**2 * np.diag(ripple**2)
        if self.equipment.encoder_time is not None:
            timed = self.rate[:, channel] * self.time_share
            total += self.equipment.encoder_time.u**2 * np.diag(timed**2)
        return total

    def _tilts(self) -> Iterator[tuple[ErrorLimit, np.ndarray, bool, np.ndarray]]:
        """The limits that tilt: groups (n,) tilted alike, whether the vertical leans, own share."""
        none = np.zeros_like(self.turn_share)
        for limit in self.equipment.angles:
            yield limit, self.settings, True, self.turn_share
        if self.equipment.axes is not None:
            yield self.equipment.axes, self.faces, True, none
        if self.equipment.fixture is not None:
            yield self.equipment.fixture, self.mountings, False, none

    def _rates(self, felt: np.ndarray) -> Iterator[Contribution]:
        for limit in dict.fromkeys(limit for at in self.rate_limits.values() for limit in at):
            common = sum(felt[i] for i, at in self.rate_limits.items() if limit in at)
            yield Contribution(limit.quantity, -float(common))
        if self.equipment.ripple is not None:
            left = float(np.linalg.norm(felt * self.ripple_share))
            yield Contribution(self.equipment.ripple.quantity, left)
        if self.equipment.encoder_time is not None:
            left = float(np.linalg.norm(felt * self.time_share))
            yield Contribution(self.equipment.encoder_time.quantity, left)

    def _angles(self, weights: np.ndarray, rate: np.ndarray) -> Iterator[Contribution]:
        felt = (weights.T * self.tilt).sum(axis=2)
        lean = float(np.linalg.norm((weights.T * self.lean).sum(axis=(1, 2))))
        for limit, groups, leans, share in self._tilts():
            common = np.hypot(_summed(felt, groups), np.linalg.norm(rate * share))
            yield Contribution(limit.quantity, float(np.hypot(common, leans * lean)))


def _summed(felt: np.ndarray, numbers: np.ndarray) -> float:
    """√Σ over groups and body axes (3, n) of what one error common to a group does."""
    return float(np.linalg.norm([np.bincount(numbers, row) for row in felt]))


def equipment_response(
    evidence: ClauseEvidence,
    motion: Motion,
    terms_at: Callable[[float], tuple[Term, ...]],
    values: np.ndarray,
    equipment: Equipment,
) -> EquipmentResponse:
    """How the readings of a model follow the equipment's errors.

    motion: of the segments; terms_at: the list of terms with the latitude off by so many rad;
    values: (p,) of its parameters.
    """
    terms = terms_at(0.0)
    reads = predict(terms, motion, values)

    def reading_change(other: Motion, model: tuple[Term, ...] = terms) -> np.ndarray:
        return np.nan_to_num((predict(model, other, values) - reads) / STEP)

    speed = np.nan_to_num(np.linalg.norm(motion.rate, axis=1))
    seconds = np.array([segment.seconds for segment in evidence.segments])
    turned = speed * seconds
    by_angle = np.array([label.kind == "rotation" for label in evidence.labels], bool)
    held = ~by_angle & (speed > 0)
    place = [_setting(evidence, i) for i in range(len(speed))]
    face = [up or alone for up, alone in zip(evidence.up, place, strict=True)]
    mount = face if not evidence.mounted_once else [""] * len(face)
    level = _level_directions(evidence, motion)
    return EquipmentResponse(
        tilt=np.array([reading_change(_tilted(motion, axis)) for axis in np.eye(3)]),
        lean=np.array(
            [
                reading_change(replace(motion, up=motion.up + STEP * direction))
                for direction in level
            ]
        ),
        rate=reading_change(replace(motion, rate=motion.rate * (1.0 + STEP))),
        gravity=reading_change(replace(motion, gravity=motion.gravity * (1.0 + STEP))),
        latitude=reading_change(motion, terms_at(STEP)),
        settings=_numbered(place),
        faces=_numbered(face),
        mountings=_numbered(mount),
        turn_share=np.where(by_angle, 1.0 / np.where(by_angle, turned, 1.0), 0.0),
        ripple_share=held * 1.0 / np.maximum(turned, MIN_RIPPLE_ANGLE),
        time_share=held * math.sqrt(2.0) / np.where(held, seconds, 1.0),
        rate_limits={i: equipment.rate_at(speed[i]) for i in np.flatnonzero(held).tolist()},
        equipment=equipment,
        local_gravity=motion.gravity,
    )


def _setting(evidence: ClauseEvidence, i: int) -> str:
    """What the table's angles were set for: a rest of its own, or a run of rates with its rests."""
    label, up = evidence.labels[i], evidence.up[i]
    if label.kind != "static":
        return f"run {up or label.axis}"
    return f"run {up}" if label.item == "rate_sensitivity" and up else f"rest {i}"


def _level_directions(evidence: ClauseEvidence, motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Two perpendicular level directions (n, 3) in the body; zero in turns, as on average.

    North and east if known, otherwise by the turns that the labels state.
    """
    first = motion.north.copy()
    for i, segment in enumerate(evidence.segments):
        up = motion.up[i]
        if segment.segment.kind != "static":
            first[i] = 0.0
        elif not np.isfinite(first[i]).all() and np.isfinite(up).all():
            across = np.cross(up, np.roll(np.eye(3)[np.abs(up).argmax()], 1))
            turn = np.radians(segment.segment.turn_deg or 0.0)
            first[i] = np.cos(turn) * across + np.sin(turn) * np.cross(up, across)
    return first, np.cross(first, motion.up)


def _tilted(motion: Motion, axis: np.ndarray) -> Motion:
    """The body turned a little about one of its axes: what it feels turns the other way."""
    turned = {
        name: getattr(motion, name) + STEP * np.cross(getattr(motion, name), axis)
        for name in ("up", "north", "rate")
    }
    return replace(motion, **turned)


def _numbered(names: list[str]) -> np.ndarray:
    return np.unique(names, return_inverse=True)[1] if names else np.zeros(0, int)
