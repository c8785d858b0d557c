"""What the equipment may be wrong by, put through the joint solution (type B).

Each limit changes what the unit went through, and the change of the readings goes through the
operator of the fit: δθ = O·δy. A table angle is wrong by its own amount in every rest; the axis
of a run of rates, the fixture and the table's squareness by one amount while the unit stays
mounted. Nobody says which errors two faces of a fixture share: the larger of both readings
counts, common to an axis up and down, or each face its own.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from tasks.items.evidence import Evidence
from tasks.model.simulate import predict
from tasks.model.term import Term
from tasks.motion.whole import Motion
from tasks.uncertainty.budget import Contribution
from tasks.uncertainty.equipment import Equipment, Limit

STEP = 1e-5  # rad, or relative: small beside one, large beside rounding
SLOWLY = 2.0  # rad: over a smaller angle a ripple within the turn does not average out

Group = list[int]


@dataclass(frozen=True)
class Disturbed:
    """How the mean readings follow the equipment's errors, per unit of each.

    tilt: (3, n, 6) per rad about each body axis. rate, gravity: (n, 6) per relative error.
    latitude: (n, 6) per rad.
    each: groups of segments with an angle error of their own; pairs, faces: the two readings of
    what is common to a mounting. turns: segments turned by an angle (rad).
    """

    tilt: np.ndarray
    rate: np.ndarray
    gravity: np.ndarray
    latitude: np.ndarray
    each: tuple[Group, ...]
    pairs: tuple[Group, ...]
    faces: tuple[Group, ...]
    turned: np.ndarray
    by_angle: np.ndarray
    speed: np.ndarray
    equipment: Equipment
    local_gravity: float

    def lines(self, channel: int, weights: np.ndarray) -> tuple[Contribution, ...]:
        """The lines of o·U for one channel; weights: o (n,)."""
        return (
            *self._rates(weights * self.rate[:, channel]),
            *self._angles(weights * self.tilt[:, :, channel], weights * self.rate[:, channel]),
            *self._line(self.equipment.gravity, weights @ self.gravity[:, channel]
                        / self.local_gravity),
            *self._line(self.equipment.latitude, weights @ self.latitude[:, channel]),
        )  # fmt: skip

    def _rates(self, felt: np.ndarray) -> Iterable[Contribution]:
        held = np.flatnonzero(~self.by_angle & (self.speed > 0))
        limits = {i: self.equipment.rate_at(self.speed[i]) for i in held}
        for limit in dict.fromkeys(limit for found in limits.values() for limit in found):
            common = sum(felt[i] for i in held if limit in limits[i])
            yield from self._line(limit, float(common))
        if self.equipment.ripple is not None:
            share = np.minimum(1.0, SLOWLY / np.maximum(self.turned[held], SLOWLY))
            yield from self._line(self.equipment.ripple, float(np.linalg.norm(felt[held] * share)))

    def _angles(self, felt: np.ndarray, rates: np.ndarray) -> Iterable[Contribution]:
        """felt: (3, n) per rad about each body axis; rates: (n,) per relative error of a turn."""
        own = float(np.linalg.norm(rates[self.by_angle] / self.turned[self.by_angle]))
        each = float(np.hypot(_summed(felt, self.each), own))
        mounting = max(_summed(felt, self.pairs), _summed(felt, self.faces))
        for limit in self.equipment.angles:
            yield from self._line(limit, each)
        for limit in self.equipment.squareness:
            yield from self._line(limit, mounting)

    def _line(self, limit: Limit, sensitivity: float) -> Iterable[Contribution]:
        if sensitivity != 0.0:
            yield Contribution(limit.quantity(), sensitivity)


def _summed(felt: np.ndarray, groups: tuple[Group, ...]) -> float:
    """√Σ over groups and body axes of what one error common to a group does."""
    return float(np.linalg.norm([felt[:, group].sum(axis=1) for group in groups]))


def disturbed(
    evidence: Evidence,
    motion: Motion,
    terms_at: Callable[[float], tuple[Term, ...]],
    values: np.ndarray,
    equipment: Equipment,
) -> Disturbed:
    """How the readings of a model follow the equipment's errors.

    motion: of the segments; terms_at: the list of terms with the latitude off by so many rad;
    values: (p,) of its parameters.
    """
    terms = terms_at(0.0)
    reads = predict(terms, motion, values)

    def changed(other: Motion, model: tuple[Term, ...] = terms) -> np.ndarray:
        return np.nan_to_num((predict(model, other, values) - reads) / STEP)

    segments = [segment.segment for segment in evidence.segments]
    speed = np.nan_to_num(np.linalg.norm(motion.rate, axis=1))
    seconds = np.array([segment.seconds for segment in evidence.segments])
    still = [s.kind == "static" for s in segments]
    run = [f"about {s.axis}" for s in segments]
    place = [f"rest {i}" if rest else run[i] for i, rest in enumerate(still)]
    face = [(evidence.up[i] or place[i]) if rest else run[i] for i, rest in enumerate(still)]
    pair = [axis.lstrip("+-") for axis in face]
    return Disturbed(
        tilt=np.array([changed(_tilted(motion, axis)) for axis in np.eye(3)]),
        rate=changed(replace(motion, rate=motion.rate * (1.0 + STEP))),
        gravity=changed(replace(motion, gravity=motion.gravity * (1.0 + STEP))),
        latitude=changed(motion, terms_at(STEP)),
        each=_groups(place),
        pairs=_groups(pair),
        faces=_groups(face),
        turned=speed * seconds,
        by_angle=np.array([s.kind == "rotation" for s in segments], bool),
        speed=speed,
        equipment=equipment,
        local_gravity=motion.gravity,
    )


def _tilted(motion: Motion, axis: np.ndarray) -> Motion:
    """The body turned a little about one of its axes: what it feels turns the other way."""
    turned = {
        name: getattr(motion, name) + STEP * np.cross(getattr(motion, name), axis)
        for name in ("up", "north", "rate")
    }
    return replace(motion, **turned)


def _groups(names: list[str]) -> tuple[Group, ...]:
    found: dict[str, Group] = {}
    for i, name in enumerate(names):
        found.setdefault(name, []).append(i)
    return tuple(found.values())
