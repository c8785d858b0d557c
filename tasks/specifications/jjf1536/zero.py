"""7.2: zero offset by four positions or by positions at equal angles, eq. (16)."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import AXES, Axis
from schemas.text import Remark
from tasks.motion.table import EARTH_RATE
from tasks.segments.attitude import COMPONENTS, VERTICAL, attitude_contradicted
from tasks.specifications.error_sources import EquipmentErrors
from tasks.specifications.estimate import (
    DEG,
    ClauseResult,
    Estimate,
    Estimates,
    ItemEstimate,
    item_by_axis,
    linear_estimate,
    u_of_means,
    undetermined,
)
from tasks.specifications.jjf1536.evidence import AhrsEvidence, is_zero_position
from tasks.specifications.jjf1536.scale import scatter_remark
from tasks.specifications.linear import BirgeRatio, birge_ratio, solve
from tasks.uncertainty.budget import Contribution, InputQuantity, observed
from tasks.uncertainty.drift import WALK
from tasks.words import Message, message, remark

ZERO_OFFSET = "ahrs_zero_offset"
CLAUSE = "JJF 1536-2015, 7.2.3 eq. (16)"
READINGS = ("jjf1536.zero_time", "jjf1536.earth_cancels")
CANCELS = 0.005  # of Earth's rotation that positions at equal angles may leave, 0.3° of placing
TAKEN_OFF = 0.1  # of it, that may be taken off where the mounts state by how much they stood aslant
ALONG = 0.1  # of a direction: what a crooked mount lays along it says nothing of what is there
COUPLING = 0.01  # rad: what a gyro may feel of Earth's rotation about the other axes
SAME_ATTITUDE = 0.02  # rad: attitudes closer than this are one position held twice
FEWEST = 4  # positions that may be taken by their label alone
DWELL_S = {4: 1800.0, 12: 1200.0}  # s for each position of the two methods, 7.2.1 and 7.2.2


@dataclass(frozen=True)
class Positions:
    """The positions that serve one axis.

    groups: indices of the rests, those of one position together.
    direction: (positions, 15) where the axis points; None where neither label nor table gives it.
    others: (2, positions, 15) where the other axes point.
    up: (positions, 3) how much of each axis points up.
    """

    axis: Axis
    groups: tuple[tuple[int, ...], ...]
    direction: np.ndarray | None
    others: np.ndarray
    up: np.ndarray

    @property
    def rests(self) -> list[int]:
        return [i for group in self.groups for i in group]


def zero_items(evidence: AhrsEvidence, errors: EquipmentErrors) -> ClauseResult:
    """B (3,) of eq. (16), deg/s: the mean over the positions of the angle gained per second."""

    def of_axis(channel: int, axis: Axis) -> tuple[Estimates, Iterable[Remark]] | Message:
        positions = _positions(evidence, channel)
        why = _not_determined(evidence, positions)
        if why is not None:
            return message("specifications-of-axis", axis=axis, reason=why)
        drift = _drift(evidence, channel, errors)
        mean, factor = _mean(evidence, channel, positions, None if drift else errors)
        mean = mean.with_lines(*_drift_line(evidence, channel, mean, drift))
        if evidence.loses_steady_rates:  # and by how much of its own zero nobody knows
            mean = replace(mean, lines=(observed(math.nan, ""),))
        scatter = scatter_remark("jjf1536-positions-scatter", axis, factor)
        drifts = _drift_remark(axis, drift)
        return {axis: mean.scaled(DEG)}, (*_remarks(evidence, positions), *scatter, *drifts)

    result = item_by_axis(ZERO_OFFSET, ItemEstimate(undetermined(AXES), CLAUSE, READINGS), of_axis)
    return replace(result, remarks=(*_steady_remarks(evidence), *result.remarks))


def _steady_remarks(evidence: AhrsEvidence) -> Iterator[Remark]:
    """A unit that takes off what it reads for long: Earth's rotation, and its own zero with it."""
    if evidence.loses_steady_rates and evidence.steady_gain is not None:
        north, _ = evidence.steady_gain
        text = message(
            "jjf1536-steady-rate-lost", gain=f"{north.gain:.2f}", u=f"{2.0 * north.u:.2f}"
        )
        yield remark("steady_rate_lost", text, blocks_pass=True)


def _positions(evidence: AhrsEvidence, channel: int) -> Positions:
    """The rests of 7.2 whose label names the axis; where no label names one, all of them."""
    held = [i for i, segment in enumerate(evidence.segments) if is_zero_position(segment)]
    axis = AXES[channel]
    if any(evidence.segments[i].segment.axis for i in held):
        held = [i for i in held if evidence.segments[i].segment.axis == axis]
    groups: list[list[int]] = []
    first: list[np.ndarray] = []
    for i in held:
        vector = evidence.attitude[i]
        if vector is None:
            nowhere = np.zeros((len(held), 3))
            return Positions(axis, tuple((i,) for i in held), None, nowhere[None], nowhere)
        same = [g for g, p in enumerate(first) if np.abs(p - vector).max() < SAME_ATTITUDE]
        if same:
            groups[same[0]].append(i)
        else:
            groups.append([i])
            first.append(vector)
    exact = np.array(first).reshape(-1, 3, COMPONENTS).round(9)  # the cosine of 90° is nothing
    direction, up = exact[:, channel], exact[:, :, VERTICAL]
    others = np.delete(exact, channel, axis=1).swapaxes(0, 1)
    return Positions(axis, tuple(tuple(group) for group in groups), direction, others, up)


def _not_determined(evidence: AhrsEvidence, positions: Positions) -> Message | None:
    """Why eq. (16) cannot be taken of these positions, None where it can."""
    count = len(positions.groups)
    if not count:
        return message("jjf1536-no-position")
    if positions.direction is None:
        return None if count >= FEWEST else message("jjf1536-few-positions", count=count)
    left, stays = positions.direction.mean(axis=0), 0.0
    if evidence.earth_in_attitude is not None:
        left, stays = left[3:], float(np.linalg.norm(left[:3]))
    if np.linalg.norm(left) <= CANCELS and stays <= TAKEN_OFF:
        return None
    remains = max(float(np.linalg.norm(left)), stays)
    return message("jjf1536-earth-remains", count=count, percent=f"{100 * remains:.0f}")


def _mean(
    evidence: AhrsEvidence, channel: int, positions: Positions, errors: EquipmentErrors | None
) -> tuple[Estimate, float]:
    """B (rad/s), and how much more than noise and equipment explain the positions differ.

    Every position counts once, so that Earth's rotation cancels; with one time T for all this is
    ΣN/(n·T). What crooked mounts leave of it is taken off where they are stated. errors: None
    where a drift already is what the positions differ by.
    """
    rests = positions.rests
    groups = np.array([[i in group for i in rests] for group in positions.groups], float)
    average = np.zeros((len(groups), len(evidence.segments)))
    average[:, rests] = groups / groups.sum(axis=1, keepdims=True)
    excess, left = BirgeRatio(), 0.0
    if positions.direction is not None:
        readings = average[:, rests] @ evidence.means[rests, channel]
        earth = evidence.earth_in_attitude
        if earth is not None:
            felt = positions.direction @ earth
            readings, left = readings - felt, float(felt.mean())
        # What gravity does to a gyro follows the attitude, too, and cancels as Earth's rotation.
        columns = np.column_stack([positions.direction, positions.up])
        columns = columns[:, np.abs(columns).max(axis=0) > ALONG]
        design = np.column_stack([np.ones(len(readings)), columns])
        if errors is not None:
            expected = evidence.covariance(channel) + errors.covariance(channel)
            covariance = average @ expected @ average.T
            for other in positions.others:
                covariance += (COUPLING * EARTH_RATE) ** 2 * other @ other.T
            excess = birge_ratio(solve(design), design, readings, covariance)
    mean = linear_estimate(evidence, channel, average.mean(axis=0), excess)
    repeated = tuple(map(float, excess.factor * u_of_means(evidence, channel, average)))
    off = abs(left) > 0.0
    return replace(
        mean, value=mean.value - left, repeated=repeated, without_earth=off
    ), excess.factor


def _drift(evidence: AhrsEvidence, channel: int, errors: EquipmentErrors) -> float:
    """Half of what the zero wanders by over the positions of all axes, rad/s.

    0 where white noise, flicker and equipment explain that. What an axis reads in its own
    positions alone says nothing of it where those lie close together within the run.
    """
    earth, every = evidence.earth_in_attitude, evidence.attitude
    held = [
        is_zero_position(s) and a is not None for s, a in zip(evidence.segments, every, strict=True)
    ]
    rests = np.flatnonzero(held)
    if earth is None or not len(rests):
        return 0.0
    attitude = np.array([every[i] for i in rests])
    slow = np.tensordot(evidence.noise.drift[WALK:, channel], evidence.noise.shapes[WALK:], axes=1)
    known = evidence.covariance(channel) + errors.covariance(channel) - slow
    covariance = known[np.ix_(rests, rests)]
    for other in np.delete(attitude, channel, axis=1).swapaxes(0, 1):
        covariance += (COUPLING * EARTH_RATE) ** 2 * other @ other.T
    design = np.column_stack([np.ones(len(rests)), attitude[:, :, VERTICAL]])
    readings = evidence.means[rests, channel] - attitude[:, channel] @ earth
    solution = solve(design)
    if birge_ratio(solution, design, readings, covariance).factor == 1.0:
        return 0.0
    return 0.5 * float(np.ptp(readings - design @ solution.of(readings)))


def _drift_line(
    evidence: AhrsEvidence, channel: int, mean: Estimate, drift: float
) -> Iterator[Contribution]:
    """The line of a drift, as far as walk and trend in the noise do not hold it already."""
    if mean.operator is None or not drift:
        return
    o = mean.operator[channel]
    slow = np.tensordot(evidence.noise.drift[WALK:, channel], evidence.noise.shapes[WALK:], axes=1)
    u = math.sqrt(max(drift**2 / 3.0 - float(o @ slow @ o), 0.0))
    name = message("uncertainty-drift-in-run")
    yield Contribution(InputQuantity("d", name, "", u, "B", "rectangular"), 1.0)


def _drift_remark(axis: Axis, drift: float) -> Iterator[Remark]:
    if drift:
        text = message("jjf1536-drift-in-run", axis=axis, drift=f"{DEG * drift:.2g}")
        yield remark("drift_in_run", text)


def _remarks(evidence: AhrsEvidence, positions: Positions) -> Iterator[Remark]:
    """Conditions of 7.2.1 and 7.2.2: labels, number of positions, time at each."""
    axis, count = positions.axis, len(positions.groups)
    held = {i: evidence.segments[i] for i in positions.rests}
    labels = [segment.segment for segment in held.values()]
    if names := tuple(s.name for s in labels if attitude_contradicted(evidence.recording, s)):
        text = message("jjf1536-attitude-contradicted", axis=axis, segments=names)
        yield remark("pointing_contradicted", text, names, blocks_pass=True)
    if positions.direction is None:
        text = message("jjf1536-attitude-not-recorded", axis=axis, count=count)
        yield remark("pointing_not_recorded", text, blocks_pass=True)
    if count < FEWEST:
        text = message("jjf1536-number-of-positions", axis=axis, count=count)
        yield remark("number_of_positions", text, blocks_pass=True)
    asked = DWELL_S[4] if count <= FEWEST else DWELL_S[12]
    interval = max(segment.seconds / segment.rows for segment in held.values())
    short = [segment for segment in held.values() if segment.seconds < asked - 2 * interval]
    if short:
        text = message(
            "jjf1536-short-position",
            axis=axis,
            minutes=f"{min(segment.seconds for segment in short) / 60:.1f}",
            asked=f"{asked / 60:.0f}",
        )
        yield remark("short_position", text, tuple(s.segment.name for s in short))
