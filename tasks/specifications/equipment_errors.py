"""Errors of the measuring equipment as terms with a prior, and what each does to the means.

An error changes what the unit went through; the change of its readings is that of the unit's model
at the motion of the run. Every value of a result is a combination o·U of the segment means: a line
of its budget is the error's effect under o, times its prior. Its scope is what shares one draw of
it: the run, a mounting, an angle of an axis whenever it comes back, a setting, a face, a point.

Where encoders show how the table stood, an angle's error turns the unit about that axis, and axes
that are not square tilt it by how the table stands for it. Labels alone do not say that: the unit
is then tilted about any of its axes, in each setting and in each face, by an error of its own.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from typing import Literal

import numpy as np

from schemas.recording import AXES, Segment
from schemas.text import Remark
from tasks.model.model import predict
from tasks.model.term import Term
from tasks.motion.table import (
    EARTH_RATE,
    axis_directions,
    labelled_direction,
    mount_of,
    rotation,
    table_angles,
)
from tasks.motion.whole import Motion, unit_vector
from tasks.segments.attitude import VERTICAL, attitude_vector
from tasks.segments.rates import rate_by_command
from tasks.segments.summarise import CHANNELS
from tasks.specifications.evidence import ClauseEvidence
from tasks.uncertainty.budget import Contribution, InputQuantity
from tasks.uncertainty.equipment import NOBODY, Equipment, ErrorLimit
from tasks.words import message, remark

# An error as a term with a prior, what it does to the segment means, and all those of a run.

LEAST_SHARE = 1e-6  # of the largest line of a budget: rounding, not a line of its own

Scope = Literal["run", "mounting", "face", "angle", "setting", "point"]


@dataclass(frozen=True)
class ErrorSource:
    """One error of the equipment: its prior, its scope, and what it does to the means.

    effects: (m, n, 6), of each of its m independent draws on the n segment means of six channels,
    rad/s and m/s² per unit. followed: by parameters of the unit, as the rate is by a scale factor:
    nothing of it is left of a fit. of_latitude: it acts only where Earth's rotation is taken off.
    """

    quantity: InputQuantity
    scope: Scope
    effects: np.ndarray
    followed: bool = False
    of_latitude: bool = False

    def line(self, weights: np.ndarray, channels: np.ndarray, segments: np.ndarray) -> Contribution:
        """The line in the budget of Σ o·U: independent draws count as root of the sum of their
        squares.

        weights: o of some channels (c,) in some segments (k,), (c, k); of all others it is zero.
        """
        felt = np.einsum("mnc,cn->m", self.effects[:, segments[:, None], channels], weights)
        if len(felt) == 1 or not felt.any():
            return Contribution(self.quantity, float(felt[0]))
        squares = felt**2
        draws = squares.sum() ** 2 / (squares**2).sum()  # Kish's effective number
        return Contribution(self.quantity, float(np.sqrt(squares.sum())), float(draws))


@dataclass(frozen=True)
class EquipmentErrors:
    """Every error of the equipment of a run with so many segments."""

    sources: tuple[ErrorSource, ...]
    segments: int

    def lines(self, operator: np.ndarray, without_earth: bool) -> tuple[Contribution, ...]:
        """The lines of Σ o·U, o (6, n), but rounding; without_earth: Earth's rate was taken off."""
        channels, segments = (np.flatnonzero(operator.any(axis=axis)) for axis in (1, 0))
        weights = operator[np.ix_(channels, segments)]
        every = [
            each.line(weights, channels, segments)
            for each in self.sources
            if without_earth or not each.of_latitude
        ]
        sizes = [abs(line.sensitivity) * line.quantity.u for line in every]
        least = LEAST_SHARE * max(sizes, default=0.0)
        return tuple(line for line, size in zip(every, sizes, strict=True) if size > least)

    def covariance(self, channel: int) -> np.ndarray:
        """Covariance (n, n) of one channel's means by what no parameter of the unit follows."""
        total = np.zeros((self.segments, self.segments))
        for each in self.sources:
            if not each.followed and each.quantity.source != NOBODY:
                effects = each.effects[:, :, channel]
                total += each.quantity.u**2 * (effects.T @ effects)
        return total


# How the axes of a table stood in each segment, by its encoders or by the labels.

SAME_ANGLE = 0.01  # degrees: a table set twice within this was set to the same angle
UP = np.array([0.0, 0.0, 1.0])
PARALLEL = math.cos(math.radians(1.0))
TURNED = math.radians(1.0)  # of an axis within a segment: less is its servo


@dataclass(frozen=True)
class AxesOfTable:
    """How the axes of a table stood.

    angles: (n, k) rad, mean of each segment; turns: (n, k) whether the axis turned in it.
    """

    angles: np.ndarray
    turns: np.ndarray

    @property
    def count(self) -> int:
        return self.angles.shape[1]

    def angles_set(self, axis: int) -> list[int | None]:
        """The angle at which the axis stood, as a number; None where it turned."""
        steps = np.round(np.degrees(self.angles[:, axis]) / SAME_ANGLE).astype(int)
        whole = round(360.0 / SAME_ANGLE)
        return [
            None if turns else int(step % whole)
            for step, turns in zip(steps, self.turns[:, axis], strict=True)
        ]

    def times_set(self, axis: int) -> list[int | None]:
        """How often the axis was set before; None where it turned."""
        numbers: list[int | None] = []
        last, number = None, 0
        for angle in self.angles_set(axis):
            number += angle != last
            last = angle
            numbers.append(None if angle is None else number)
        return numbers

    def axis_in_body(self, evidence: ClauseEvidence, axis: int) -> np.ndarray:
        """Direction (n, 3) of an axis in the body."""
        return self._in_body(
            evidence, axis_directions(evidence.recording.manifest.station)[axis], axis
        )

    def joint_in_body(self, evidence: ClauseEvidence, axis: int) -> np.ndarray:
        """Across an axis and the next inside it, (n, 3) in the body: about it they are not square.

        Zero where the two are parallel.
        """
        directions = axis_directions(evidence.recording.manifest.station)
        return self._in_body(evidence, np.cross(directions[axis], directions[axis + 1]), axis)

    def _in_body(self, evidence: ClauseEvidence, vector: np.ndarray, outside: int) -> np.ndarray:
        """A vector fixed to what axis `outside` carries, (n, 3) as the body sees it."""
        manifest = evidence.recording.manifest
        inside = list(enumerate(axis_directions(manifest.station)))[outside + 1 :]
        seen = []
        for label, angles in zip(evidence.labels, self.angles, strict=True):
            turned = vector
            for k, direction in inside:
                turned = rotation(direction, -float(angles[k])) @ turned
            seen.append(mount_of(manifest, label).T @ turned)
        return np.array(seen).reshape(-1, 3)


def axes_of_table(evidence: ClauseEvidence) -> AxesOfTable | None:
    """By the encoders, else as the labels say; None where neither shows it in every segment."""
    angles = [table_angles(evidence.recording, label) for label in evidence.labels]
    if not angles or not all(len(each) and np.isfinite(each).all() for each in angles):
        return _by_labels(evidence)
    turns = np.array([np.ptp(each, axis=0) > TURNED for each in angles])
    return AxesOfTable(np.array([each.mean(axis=0) for each in angles]), turns)


def _by_labels(evidence: ClauseEvidence) -> AxesOfTable | None:
    """Of a table that is described, with a vertical outermost axis, which alone turns.

    The outermost axis stands at the label's heading, those inside it at right angles that bring the
    labelled axis up: of several those nearest to zero, the innermost alone to either side.
    """
    directions = axis_directions(evidence.recording.manifest.station)
    if not len(directions) or abs(directions[0] @ UP) < PARALLEL or not evidence.labels:
        return None
    polar, azimuth = (0.0, 90.0, 180.0), (0.0, 90.0, -90.0, 180.0)
    inside = [polar] * (len(directions) - 2) + [azimuth] * (len(directions) > 1)
    rows = []
    for up, label in zip(evidence.up, evidence.labels, strict=True):
        if up is None or (label.axis or up[1]) != up[1]:
            return None
        manifest = evidence.recording.manifest
        shown = mount_of(manifest, label) @ labelled_direction(manifest, label, unit_vector(up))
        bring = [d for d in product(*inside) if shown @ _vertical(directions, d) > PARALLEL]
        if not bring:
            return None
        nearest = min(bring, key=lambda degrees: sum(map(abs, degrees)))
        rows.append([math.radians(angle) for angle in (label.turn_deg or 0.0, *nearest)])
    turns = np.zeros((len(rows), len(directions)), bool)
    turns[:, 0] = [label.kind != "static" for label in evidence.labels]
    return AxesOfTable(np.array(rows), turns)


def _vertical(directions: list[np.ndarray], degrees: tuple[float, ...]) -> np.ndarray:
    """The vertical (3,) as the payload sees it, with the axes inside the outermost one set so."""
    seen = UP
    for direction, angle in zip(directions[1:], degrees, strict=True):
        seen = rotation(direction, -math.radians(angle)) @ seen
    return seen


def stand_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Says how it is known how the table stood, where encoders do not show it."""
    if not evidence.has_table:
        known = "labelled" if axes_of_table(evidence) is not None else "unknown"
        yield remark("table_by_labels", message(f"specifications-stand-{known}"))


# What turns and rests leave of the horizontal part of Earth's rotation in the mean readings.
#
# A gyro across the axis that turns about the vertical feels it come and go. Over whole turns
# nothing is left; over a part of a turn, or where the table rests before and after within a
# segment, the clauses take the reading as it is. By how much the unit turned meanwhile it says
# itself; where north was when it began is not known.


def horizontal_earth(evidence: ClauseEvidence) -> Iterator[ErrorSource]:
    """Its source, with a draw for the north and one for the east where each turn began.

    Turns by whole turns about one axis come back to where they began; a held rate begins anywhere.
    """
    turning = [i for i, label in enumerate(evidence.labels) if label.kind != "static"]
    begun = [_beginning(evidence.labels[i]) for i in turning]
    places = {place: 2 * k for k, place in enumerate(dict.fromkeys(begun))}
    effects = np.zeros((2 * len(places), len(evidence.segments), len(CHANNELS)))
    for i, place in zip(turning, begun, strict=True):
        axis = AXES.index(evidence.labels[i].axis or "x")
        left, north = evidence.mean_turns[i], places[place]
        across = [(axis + 1) % 3, (axis + 2) % 3]
        effects[north, i, across] = left.real, -left.imag
        effects[north + 1, i, across] = left.imag, left.real
    effects = np.concatenate([effects, _of_rests(evidence)])
    if effects.any():
        yield ErrorSource(_quantity(evidence.latitude_deg), "point", effects)


def _of_rests(evidence: ClauseEvidence) -> np.ndarray:
    """Effects (m, n, 6) on rests of unknown heading: two draws for each face, which turn with the
    rests on it, so that two headings 180° apart are free of it; a rest without heading has its own.
    """
    blind = [
        i
        for i in evidence.of_kind("static")
        if evidence.up[i] is not None
        and not np.isfinite(evidence.north[i]).all()
        and not _pointed(attitude_vector(evidence.recording, evidence.labels[i]))
    ]
    labels = evidence.labels
    places = [
        str(evidence.up[i] if labels[i].turn_deg is not None else labels[i].name) for i in blind
    ]
    faces = list(dict.fromkeys(places))
    effects = np.zeros((2 * len(faces), len(evidence.segments), len(CHANNELS)))
    for i, place in zip(blind, places, strict=True):
        up, turn = str(evidence.up[i]), math.radians(labels[i].turn_deg or 0.0)
        axis, way = AXES.index(up[1]), 1.0 if up[0] == "+" else -1.0
        across, k = [(axis + 1) % 3, (axis + 2) % 3], 2 * faces.index(place)
        effects[k, i, across] = math.cos(turn), -way * math.sin(turn)
        effects[k + 1, i, across] = way * math.sin(turn), math.cos(turn)
    return effects


def level_covariance(evidence: ClauseEvidence, motion: Motion, gyro: int) -> np.ndarray:
    """Covariance (n, n), (rad/s)², of one gyro's rests by a horizontal rate of unknown direction.

    motion: mean of each segment. A gyro that lies level reads ωe·cos φ·cos(ψ + heading) with ψ
    unknown: half the square of the amplitude, times the cosine of the turn between two headings of
    one face. The mean of two headings 180° apart is free of it, and its scatter is not the unit's.
    Without a latitude the whole of ωe is taken; without a heading a rest shares nothing with
    another.
    """
    still = np.array([label.kind == "static" for label in evidence.labels], bool)
    blind = still & ~np.isfinite(motion.north).all(axis=1)
    level = blind * np.sqrt(np.clip(1.0 - np.nan_to_num(motion.up[:, gyro]) ** 2, 0.0, 1.0))
    heading = np.radians(np.array([label.turn_deg for label in evidence.labels], float))
    same = [[a == b for b in evidence.up] for a in evidence.up]
    shared = np.nan_to_num(np.cos(heading[:, None] - heading)) * np.reshape(same, 2 * still.shape)
    np.fill_diagonal(shared, 1.0)
    return np.asarray(_quantity(evidence.latitude_deg).u ** 2 * np.outer(level, level) * shared)


def _pointed(attitude: np.ndarray | None) -> bool:
    """Whether an attitude vector says how the unit lies to the station, whose heading is one."""
    return attitude is not None and bool(attitude[:, :VERTICAL].any())


def _beginning(label: Segment) -> str:
    """What tells apart where segments that turn begin."""
    return f"{label.axis} {label.up}" if label.kind == "rotation" else label.name


@cache
def _quantity(latitude_deg: float | None) -> InputQuantity:
    """Earth's rotation along a horizontal direction that may be any."""
    largest = EARTH_RATE * math.cos(math.radians(latitude_deg or 0.0))
    return InputQuantity(
        "ωN", message("uncertainty-horizontal-earth"), "rad/s", largest / math.sqrt(2.0), "B",
        "arcsine", half_width=largest, source="WGS 84",
    )  # fmt: skip


STEP = 1e-5  # rad, or relative: small beside one, large beside rounding
MIN_RIPPLE_ANGLE = math.sqrt(2.0)  # rad: over a smaller one a ripple does not average out


def equipment_errors(
    evidence: ClauseEvidence,
    motion: Motion,
    terms_at: Callable[[float], tuple[Term, ...]],
    values: np.ndarray,
    equipment: Equipment,
) -> EquipmentErrors:
    """The errors of a run's equipment, for a unit of that model.

    motion: mean of each segment; terms_at: the terms with the latitude off by rad; values: (p,).
    """
    motion = _with_level(evidence, motion)
    reads = predict(terms_at(0.0), motion, values)

    def change(other: Motion, latitude: float = 0.0) -> np.ndarray:
        return np.nan_to_num((predict(terms_at(latitude), other, values) - reads) / STEP)

    response = _Response(
        tilt=np.array([change(_tilted(motion, direction)) for direction in np.eye(3)]),
        lean=np.array([change(leaned) for leaned in _leaned(motion)]),
        rate=change(replace(motion, rate=motion.rate * (1.0 + STEP))),
        drift=np.array([change(replace(motion, rate=motion.rate + STEP * d)) for d in np.eye(3)]),
        gravity=change(replace(motion, gravity=motion.gravity * (1.0 + STEP))) / motion.gravity,
        latitude=change(motion, STEP),
        heading=change(
            replace(motion, north=motion.north + STEP * np.cross(motion.up, motion.north))
        ),
    )
    sources = (
        *_of_rates(evidence, motion, response, equipment),
        *_of_table(evidence, motion, response, equipment),
        *_of_time(evidence, motion, response, equipment),
        *_of_mountings(evidence, response, equipment),
        # Of what is stated, the true value acts with the opposite sign.
        *_source(equipment.gravity, "run", -response.gravity[None], followed=True),
        *_source(
            equipment.latitude, "run", -response.latitude[None], followed=True, of_latitude=True
        ),
        *_source(equipment.heading, "run", response.heading[None], of_latitude=True),
        *horizontal_earth(evidence),
    )
    return EquipmentErrors(sources, len(evidence.segments))


@dataclass(frozen=True)
class _Response:
    """How the n mean readings of six channels follow small changes, per unit of each.

    tilt, drift: (3, n, 6) per rad, rad/s about each body axis. lean: (2, n, 6) per rad of the
    table's vertical to north, east. rate, gravity, latitude, heading: (n, 6); relative, m/s², rad.
    """

    tilt: np.ndarray
    lean: np.ndarray
    rate: np.ndarray
    drift: np.ndarray
    gravity: np.ndarray
    latitude: np.ndarray
    heading: np.ndarray

    def tilted(self, directions: np.ndarray, groups: Sequence[object]) -> np.ndarray:
        """Effects (m, n, 6) of tilts about directions (k, n, 3), by groups; None: not tilted."""
        effects = np.einsum("kni,inc->knc", directions, self.tilt)
        names = [name for name in dict.fromkeys(groups) if name is not None]
        chosen = np.array([[each == name for name in names] for each in groups], float)
        chosen = chosen.reshape(len(groups), 1, len(names), 1)
        every = chosen * effects.transpose(1, 0, 2)[:, :, None]
        draws = len(names) * len(directions)
        return every.reshape(len(groups), draws, effects.shape[2]).swapaxes(0, 1)


def _source(
    limit: ErrorLimit | None, scope: Scope, effects: np.ndarray, **flags: bool
) -> Iterator[ErrorSource]:
    """The error of a limit, where it is known and does anything."""
    if limit is not None and effects.any():
        kept = effects[effects.any(axis=(1, 2))]
        yield ErrorSource(limit.quantity, scope, kept, **flags)


def _of_rates(
    evidence: ClauseEvidence, motion: Motion, response: _Response, equipment: Equipment
) -> Iterator[ErrorSource]:
    """Of held rates, their ripple and their ends; of turned angles; of rests that creep."""
    speed = np.nan_to_num(np.linalg.norm(motion.rate, axis=1))
    seconds = np.array([segment.seconds for segment in evidence.segments])
    by_angle = np.array([label.kind == "rotation" for label in evidence.labels], bool)
    held, turned = ~by_angle & (speed > 0.0), speed * seconds

    def of_points(share: np.ndarray) -> np.ndarray:
        return np.eye(len(speed))[:, :, None] * (share[:, None] * response.rate)

    for limit, share in equipment.rate_errors(np.where(held, speed, np.nan)):
        effects = -(share[:, None] * response.rate)[None]
        yield from _source(limit, "run", effects, followed=True)
    left = held / np.maximum(turned, MIN_RIPPLE_ANGLE)  # of a ripple, over the angle turned
    arcs = _arcs(evidence, held & (turned < 2.0 * math.pi))
    alone = of_points(np.where(np.isfinite(arcs).all(axis=(0, 1)), 0.0, left))
    shared = np.nan_to_num(arcs).reshape(2 * len(arcs), len(speed), 1) * response.rate
    yield from _source(equipment.ripple, "angle", np.concatenate([alone, shared]))
    commanded = np.array(
        [rate_by_command(evidence.recording, label) is not None for label in evidence.labels], bool
    )
    timed = math.sqrt(2.0) * (held & ~commanded) / seconds
    yield from _source(equipment.encoder_time, "point", of_points(timed))
    by_command = -((held & commanded)[:, None] * response.rate)[None]
    yield from _source(equipment.commanded_rate, "run", by_command, followed=True)
    for limit in equipment.angles:
        share = by_angle / np.where(by_angle, turned, 1.0)
        name = message("uncertainty-turned-angle", limit=limit.name)
        angle = replace(limit, symbol=f"{limit.symbol}θ", name=name)
        yield from _source(angle, "point", of_points(share))
        if equipment.creeps:
            name = message("uncertainty-creep", limit=limit.name)
            crept = replace(limit, symbol=f"{limit.symbol}t", name=name)
            rests = np.array([label.kind == "static" for label in evidence.labels], bool)
            own = np.eye(len(speed))[:, :, None] * (rests / seconds)[:, None]
            yield from _source(crept, "point", np.concatenate([own * d for d in response.drift]))


def _arcs(evidence: ClauseEvidence, short: np.ndarray) -> np.ndarray:
    """What a ripple of once a turn does to mean rates over less than one, relative, by cosine and
    sine of its phase: (axes of the table, 2, n), which all that passes the same angles shares. NaN
    where no angle was recorded, or a turn was made, over which shorter waves count as independent.
    """
    count = len(evidence.recording.manifest.station.table_axes or ())
    arcs = np.full((count, 2, len(short)), np.nan)
    for i in np.flatnonzero(short).tolist():
        angles = table_angles(evidence.recording, evidence.labels[i])
        if not len(angles):
            continue
        moved = angles[-1] - angles[0]
        axis = int(np.abs(moved).argmax())
        first, last = angles[0, axis], angles[-1, axis]
        ends = math.sin(last) - math.sin(first), math.cos(last) - math.cos(first)
        arcs[:, :, i] = 0.0
        arcs[axis, :, i] = np.array(ends) / moved[axis] / math.sqrt(2.0)
    return arcs


def _of_time(
    evidence: ClauseEvidence, motion: Motion, response: _Response, equipment: Equipment
) -> Iterator[ErrorSource]:
    """Of the clock that stamps the readings, where it forms a mean reading (of accumulated angles)
    or the rate that it is compared with (of encoders, of a turn by an angle), and not both.
    """
    turning = np.nan_to_num(np.linalg.norm(motion.rate, axis=1)) > 0.0
    by_angle = np.array([label.kind == "rotation" for label in evidence.labels], bool)
    reference = by_angle | evidence.has_table
    timed = turning & (reference != evidence.accumulates)
    effects = -(timed[:, None] * response.rate)[None]
    yield from _source(equipment.time_base, "run", effects, followed=True)


def _of_mountings(
    evidence: ClauseEvidence, response: _Response, equipment: Equipment
) -> Iterator[ErrorSource]:
    """Of the fixture, and of the unit's base in it, each time that the unit is mounted."""
    tilts = response.tilted(_anyhow(evidence), evidence.mountings)
    yield from _source(equipment.fixture, "mounting", tilts)
    yield from _source(equipment.mounting, "mounting", tilts)


def _of_table(
    evidence: ClauseEvidence, motion: Motion, response: _Response, equipment: Equipment
) -> Iterator[ErrorSource]:
    """Of the table's angles, its axes and its vertical."""
    yield from _source(equipment.level, "run", response.lean)
    stands = axes_of_table(evidence)
    if stands is None:
        settings = [_setting(evidence, i) for i in range(len(evidence.labels))]
        faces = [up or alone for up, alone in zip(evidence.up, settings, strict=True)]
        # A table without a second axis turns about the vertical alone.
        about = _anyhow(evidence) if equipment.axes else np.nan_to_num(motion.up)[None]
        for limit in equipment.angles:
            yield from _source(limit, "setting", response.tilted(about, settings))
        yield from _source(equipment.axes, "face", response.tilted(_anyhow(evidence), faces))
        return
    axes = [stands.axis_in_body(evidence, k) for k in range(stands.count)]
    at = [response.tilted(axis[None], stands.angles_set(k)) for k, axis in enumerate(axes)]
    yield from _source(equipment.position, "angle", np.concatenate(at))
    each = [response.tilted(axis[None], stands.times_set(k)) for k, axis in enumerate(axes)]
    yield from _source(equipment.repeatability, "setting", np.concatenate(each))
    joints = np.array([stands.joint_in_body(evidence, k) for k in range(stands.count - 1)])
    if len(joints):
        whole_run = [0] * len(evidence.labels)
        yield from _source(equipment.axes, "run", response.tilted(joints, whole_run))


def _anyhow(evidence: ClauseEvidence) -> np.ndarray:
    """The body's axes (3, n, 3), where nothing says about which one it is tilted."""
    return np.eye(3)[:, None].repeat(len(evidence.labels), axis=1)


def _setting(evidence: ClauseEvidence, i: int) -> str:
    """What the table's angles were set for: a rest of its own, or a run of rates with its rests."""
    label, up = evidence.labels[i], evidence.up[i]
    if label.kind != "static":
        return f"run {up or label.axis}"
    return f"run {up}" if label.item == "rate_sensitivity" and up else f"rest {i}"


def _with_level(evidence: ClauseEvidence, motion: Motion) -> Motion:
    """The motion with a vertical in every turn, and a north in every rest.

    Where they are unknown: the axis that turns, and a north that follows the label.
    """
    north, up = motion.north.copy(), motion.up.copy()
    for i, label in enumerate(evidence.labels):
        if label.axis is not None and not np.isfinite(up[i]).all():
            up[i] = np.eye(3)[AXES.index(label.axis)]
        if label.kind != "static" or np.isfinite(north[i]).all():
            continue
        vector = attitude_vector(evidence.recording, label)
        if vector is not None:
            level = np.delete(vector, VERTICAL, axis=1)[:, 1::2].sum(axis=1)
        else:
            level = np.roll(motion.up[i], 1)
            level = level - (level @ motion.up[i]) * motion.up[i]
        north[i] = level / max(float(np.linalg.norm(level)), STEP)
    return replace(motion, north=north, up=up)


def _leaned(motion: Motion) -> tuple[Motion, Motion]:
    """The table's vertical leaning a little to the north, and to the east."""
    north, up = np.nan_to_num(motion.north), motion.up
    return (
        replace(motion, up=up + STEP * north, north=motion.north - STEP * up),
        replace(motion, up=up + STEP * np.cross(north, up)),
    )


def _tilted(motion: Motion, axis: np.ndarray) -> Motion:
    """The body turned a little about one of its axes: what it feels turns the other way."""
    turned = {
        name: getattr(motion, name) + STEP * np.cross(getattr(motion, name), axis)
        for name in ("up", "north", "rate")
    }
    return replace(motion, **turned)
