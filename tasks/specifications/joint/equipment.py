"""What the equipment may be wrong by, put through the joint solution (type B).

Each limit changes what the unit went through, and the change of the readings goes through the
operator of the fit: δθ = O·δy. A table angle is wrong by its own amount in every position; a run
of rates and the rests beside it have one setting. Axes that are not square tilt each face of its
own; a fixture is wrong by one amount while the unit stays mounted. The
outermost axis leans from the vertical by as much as angles and axes allow: that shows in rests,
and averages out in turns.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tasks.model.simulate import predict
from tasks.model.term import Term
from tasks.motion.whole import Motion
from tasks.specifications.evidence import Evidence
from tasks.uncertainty.budget import Contribution
from tasks.uncertainty.equipment import Equipment, Limit
from tasks.uncertainty.type_b import MIN_RIPPLE_ANGLE

STEP = 1e-5  # rad, or relative: small beside one, large beside rounding

LEAST_SHARE = 1e-6  # of the largest line of a budget: rounding, not a line of its own


@dataclass(frozen=True)
class EquipmentError:
    """What one limit does to the mean readings.

    readings: (k, n, 6), of k independent errors, per unit of each. followed: whether the
    parameters follow it, so that nothing of it is left over.
    """

    limit: Limit
    readings: np.ndarray
    followed: bool = False

    def line(self, weights: np.ndarray) -> Contribution:
        """The line of Σ o·U over the channels; weights: o (6, n).

        By what is told of rate, gravity and latitude: what they truly are acts the other way.
        """
        errors = (weights.T * self.readings).sum(axis=(1, 2))
        sensitivity = -errors.sum() if self.followed else np.linalg.norm(errors)
        return Contribution(self.limit.quantity(), float(sensitivity))


@dataclass(frozen=True)
class EquipmentResponse:
    """How the mean readings of n segments follow the equipment's errors."""

    errors: tuple[EquipmentError, ...]

    def lines(self, weights: np.ndarray) -> tuple[Contribution, ...]:
        """The lines of Σ o·U over the channels; weights: o (6, n)."""
        every = [error.line(weights) for error in self.errors]
        sizes = [abs(line.sensitivity) * line.quantity.u for line in every]
        least = LEAST_SHARE * max(sizes)
        return tuple(line for line, size in zip(every, sizes, strict=True) if size > least)

    def covariance(self, channel: int) -> np.ndarray:
        """Covariance (n, n) of one channel's means by what the model cannot follow: the angles.

        Rate, gravity and latitude change the parameters, not what is left over.
        """
        n = self.errors[0].readings.shape[1]
        total = np.zeros((n, n))
        for error in self.errors:
            if not error.followed:
                of_channel = error.readings[:, :, channel]
                total += error.limit.u**2 * (of_channel.T @ of_channel)
        return total


def equipment_response(
    evidence: Evidence,
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

    def changed(other: Motion, model: tuple[Term, ...] = terms) -> np.ndarray:
        return np.nan_to_num((predict(model, other, values) - reads) / STEP)

    tilt = [changed(_tilted(motion, axis)) for axis in np.eye(3)]
    lean = [
        changed(replace(motion, up=motion.up + STEP * direction))
        for direction in _level_directions(evidence, motion)
    ]
    rate = changed(replace(motion, rate=motion.rate * (1.0 + STEP)))
    gravity = changed(replace(motion, gravity=motion.gravity * (1.0 + STEP))) / motion.gravity
    latitude = changed(motion, terms_at(STEP))

    def tilts(group: Sequence[str]) -> list[np.ndarray]:
        """(n, 6) for each group and body axis: one tilt common to the group."""
        names = np.array(group)
        return [
            reading * (names == name)[:, None] for name in dict.fromkeys(group) for reading in tilt
        ]

    def rates(share: np.ndarray) -> list[np.ndarray]:
        """(n, 6) for each segment with a share (n,): a relative error of its own rate."""
        return [rate * (share * own)[:, None] for own in np.eye(len(share))[share != 0.0]]

    setting = [_setting(evidence, i) for i in range(len(evidence.segments))]
    face = [up or own for up, own in zip(evidence.up, setting, strict=True)]
    mounting = [""] * len(face) if evidence.mounted_once else face
    speed = np.nan_to_num(np.linalg.norm(motion.rate, axis=1))
    turned = speed * [segment.seconds for segment in evidence.segments]
    by_angle = np.array([label.kind == "rotation" for label in evidence.labels], bool)
    held = ~by_angle & (speed > 0)
    of_turn = np.where(by_angle, 1.0 / np.where(by_angle, turned, 1.0), 0.0)
    of_ripple = held / np.maximum(turned, MIN_RIPPLE_ANGLE)
    limits = [equipment.rate_at(v) if on else () for v, on in zip(speed, held, strict=True)]
    position = [*tilts(setting), *rates(of_turn), *lean]
    separate = (
        (equipment.ripple, rates(of_ripple)),
        *((limit, position) for limit in equipment.angles),
        (equipment.axes, [*tilts(face), *lean]),
        (equipment.fixture, tilts(mounting)),
    )
    return EquipmentResponse((
        *(
            EquipmentError(limit, (rate * [[limit in at] for at in limits])[None], followed=True)
            for limit in dict.fromkeys(limit for at in limits for limit in at)
        ),
        *(
            EquipmentError(limit, np.array(errors).reshape(-1, *rate.shape))
            for limit, errors in separate
            if limit is not None
        ),
        EquipmentError(equipment.gravity, gravity[None], followed=True),
        EquipmentError(equipment.latitude, latitude[None], followed=True),
    ))  # fmt: skip


def _setting(evidence: Evidence, i: int) -> str:
    """What the table's angles were set for: a rest of its own, or a run of rates with its rests."""
    label, up = evidence.segments[i].segment, evidence.up[i]
    if label.kind != "static":
        return f"run {up or label.axis}"
    return f"run {up}" if label.item == "rate_sensitivity" and up else f"rest {i}"


def _level_directions(evidence: Evidence, motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Two level directions (n, 3) across each other, in the body; zero in turns, as on average.

    North and east where they are known, else by the turns that the labels tell.
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
