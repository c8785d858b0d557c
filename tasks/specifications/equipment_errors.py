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

import numpy as np

from schemas.recording import AXES
from tasks.model.simulate import predict
from tasks.model.term import Term
from tasks.motion.table import table_angles
from tasks.motion.whole import Motion
from tasks.segments.attitude import VERTICAL, attitude_vector
from tasks.segments.commanded_rate import rate_by_command
from tasks.specifications.axes_of_table import axes_of_table
from tasks.specifications.error_sources import EquipmentErrors, ErrorSource, Scope
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.horizontal_earth import horizontal_earth
from tasks.uncertainty.equipment import Equipment, ErrorLimit
from tasks.words import message

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
