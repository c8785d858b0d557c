"""7.2: zero offset by four positions or by positions at equal angles, eq. (16)."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import AXES, Axis
from schemas.text import Remark
from tasks.motion.table import EARTH_RATE
from tasks.segments.attitude import COMPONENTS, VERTICAL, attitude_contradicted
from tasks.specifications.equipment_errors import EquipmentErrors
from tasks.specifications.estimate import (
    DEG,
    ClauseResult,
    Estimate,
    Estimates,
    ItemEstimate,
    MeansFit,
    item_by_axis,
    linear_estimate,
    u_of_means,
    undetermined,
)
from tasks.specifications.evidence import BLOCKING_EXCESS, BirgeRatio, birge_ratio, solve
from tasks.specifications.jjf1536.evidence import AhrsEvidence, is_zero_position, reads_another_rate
from tasks.specifications.unit_model import distinct_rates, fit_line, rate_remarks, weights_about
from tasks.uncertainty.budget import observed
from tasks.words import Message, message, remark

# 7.1: scale factor by least squares over the rate points, eq. (10) to (15).

SCALE_CLAUSE = "JJF 1536-2015, 7.1.2 eq. (10)-(15)"
SCALE_FACTOR = "ahrs_scale_factor"

Rests = tuple[tuple[int, ...], tuple[int, ...]]  # before and after the rate points


def scale_items(evidence: AhrsEvidence, rate: np.ndarray, errors: EquipmentErrors) -> ClauseResult:
    """K (3,) of eq. (14): the output of each point less the mean of the rests, eq. (11) to (13)."""
    readings: tuple[str, ...] = ("jjf1536.output_rate",) if evidence.by_angle else ()
    readings += ("jjf1536.table_rate",) if evidence.has_table else ()

    turned = [a for a in AXES if len(distinct_rates(evidence.rate[list(evidence.points[a])])) > 1]

    def of_axis(channel: int, axis: Axis) -> tuple[Estimates, Iterable[Remark]] | Message:
        points = list(evidence.points[axis])
        count = len(distinct_rates(evidence.rate[points]))
        if count < 2:
            return message("specifications-rates-needed", axis=axis, count=count)
        rests = _rests(evidence, points, axis)
        line = _line(evidence, channel, axis, errors)
        lines = {a: line if a == axis else _line(evidence, channel, a, errors) for a in turned}
        slopes = {a: each.estimates[0].operator for a, each in lines.items()}
        read = {a: o[channel] for a, o in slopes.items() if o is not None}
        weights = weights_about(evidence, axis, rate, evidence.points, read)
        if weights is None:
            return message("jjf1536-crooked", axis=axis)
        estimate = linear_estimate(evidence, channel, weights, line.excess)
        return {axis: estimate}, (
            *rate_remarks(axis, evidence.rate[points], "7.1.1 c)"),
            *_rest_remarks(axis, rests),
            *scatter_remark("jjf1536-line-scatter", axis, line.excess.factor),
        )

    item = ItemEstimate(undetermined(AXES), SCALE_CLAUSE, readings)
    scale = item_by_axis(SCALE_FACTOR, item, of_axis)
    return replace(scale, remarks=(*scale.remarks, *_other_rate_remarks(evidence)))


def _line(evidence: AhrsEvidence, channel: int, axis: Axis, errors: EquipmentErrors) -> MeansFit:
    """What a channel reads per rate about the table's axis, with an axis of the unit along it."""
    points = list(evidence.points[axis])
    rests = [i for side in _rests(evidence, points, axis) for i in side]
    return fit_line(evidence, channel, points, errors, rests)


def _rests(evidence: AhrsEvidence, points: list[int], axis: Axis) -> Rests:
    """The rest at the beginning and the one at the end of a rate run, eq. (11); empty if none.

    They are the nearest ones with the same axis up.
    """
    segments = evidence.segments
    first = min(segments[i].t_start for i in points)
    last = max(segments[i].t_end for i in points)
    known = {str(evidence.up[i]) for i in points if evidence.up[i]}
    ups = sorted(known or {f"+{axis}", f"-{axis}"})
    rests = [i for up in ups for i in evidence.rests[up]]
    before = [i for i in rests if segments[i].t_end <= first + 1e-6]
    after = [i for i in rests if segments[i].t_start >= last - 1e-6]
    start = (max(before, key=lambda i: segments[i].t_end),) if before else ()
    end = (min(after, key=lambda i: segments[i].t_start),) if after else ()
    return start, end


def _other_rate_remarks(evidence: AhrsEvidence) -> Iterator[Remark]:
    """Rate points about an axis that did not read them: another one was turned."""
    for segment, rate in zip(evidence.segments, evidence.rate, strict=True):
        name, axis = segment.segment.name, segment.segment.axis
        if axis and np.isfinite(rate) and reads_another_rate(segment, rate):
            text = message(
                "jjf1536-rate-not-read", segment=name, axis=axis, rate=f"{np.degrees(rate):+.2f}",
                reading=f"{np.degrees(segment.mean[AXES.index(axis)]):+.2f}",
            )  # fmt: skip
            yield remark("rate_not_read", text, (name,), blocks_pass=True)


def _rest_remarks(axis: str, rests: Rests) -> Iterator[Remark]:
    """Eq. (11) takes a rest at the beginning and one at the end."""
    absent = [side for side, held in zip(("before", "after"), rests, strict=True) if not held]
    if absent:
        text = message(f"jjf1536-no-rest-{'-or-'.join(absent)}", axis=axis)
        yield remark("rest_missing", text, blocks_pass=True)


def scatter_remark(text: str, axis: str, factor: float) -> Iterator[Remark]:
    """A remark where the points of an axis scatter more than expected; text: its message."""
    if factor > 1.0:
        phrase = message(text, axis=axis, factor=f"{factor:.1f}")
        yield remark("excess_scatter", phrase, blocks_pass=factor > BLOCKING_EXCESS)


ZERO_OFFSET = "ahrs_zero_offset"
ZERO_CLAUSE = "JJF 1536-2015, 7.2.3 eq. (16)"
READINGS = ("jjf1536.zero_time", "jjf1536.earth_cancels")
CANCELS = 0.005  # of Earth's rotation that positions at equal angles may leave, 0.3° of placing
TAKEN_OFF = 0.1  # of it, that may be taken off where the mounts state by how much they stood aslant
ALONG = 0.1  # of a direction: what a crooked mount lays along it says nothing of what is there
COUPLING = 0.01  # rad: what a gyro may feel of Earth's rotation about the other axes
SAME_ATTITUDE = 0.02  # rad: attitudes closer than this are one position held twice
FEWEST_POSITIONS = 4  # positions that may be taken by their label alone
DWELL_S = {4: 1800.0, 12: 1200.0}  # s for each position of the two methods, 7.2.1 and 7.2.2


@dataclass(frozen=True)
class Positions:
    """The positions that serve one axis.

    groups: indices of the rests, those of one position together.
    attitude: (positions, 3, 15) of each; None where neither label nor table gives it.
    """

    axis: Axis
    groups: tuple[tuple[int, ...], ...]
    attitude: np.ndarray | None

    @property
    def rests(self) -> list[int]:
        return [i for group in self.groups for i in group]


def zero_items(evidence: AhrsEvidence, errors: EquipmentErrors) -> ClauseResult:
    """B (3,) of eq. (16), deg/s: the mean over the positions of the angle gained per second."""

    def of_axis(channel: int, axis: Axis) -> tuple[Estimates, Iterable[Remark]] | Message:
        positions = _positions(evidence, axis)
        why = _not_determined(evidence, channel, positions)
        if why is not None:
            return message("specifications-of-axis", axis=axis, reason=why)
        mean, factor = _mean(evidence, channel, positions, errors)
        if evidence.loses_steady_rates:  # and by how much of its own zero nobody knows
            mean = replace(mean, lines=(observed(math.nan, ""),))
        scatter = scatter_remark("jjf1536-positions-scatter", axis, factor)
        return {axis: mean.scaled(DEG)}, (*_remarks(evidence, positions), *scatter)

    result = item_by_axis(
        ZERO_OFFSET, ItemEstimate(undetermined(AXES), ZERO_CLAUSE, READINGS), of_axis
    )
    return replace(result, remarks=(*_steady_remarks(evidence), *result.remarks))


def _steady_remarks(evidence: AhrsEvidence) -> Iterator[Remark]:
    """A unit that takes off what it reads for long: Earth's rotation, and its own zero with it."""
    if evidence.loses_steady_rates and evidence.earth is not None:
        gain, u = f"{evidence.earth.gain:.2f}", f"{2.0 * evidence.earth.u:.2f}"
        text = message("jjf1536-steady-rate-lost", gain=gain, u=u)
        yield remark("steady_rate_lost", text, blocks_pass=True)


def _positions(evidence: AhrsEvidence, axis: Axis) -> Positions:
    """The rests of 7.2 whose label names the axis; where no label names one, all of them."""
    held = [i for i, segment in enumerate(evidence.segments) if is_zero_position(segment)]
    if any(evidence.labels[i].axis for i in held):
        held = [i for i in held if evidence.labels[i].axis == axis]
    attitude = evidence.attitudes_of(held)
    if attitude is None:
        return Positions(axis, tuple((i,) for i in held), None)
    groups: dict[int, list[int]] = {}
    for i, vector in enumerate(attitude):
        same = [g for g in groups if np.abs(attitude[g] - vector).max() < SAME_ATTITUDE]
        groups.setdefault(same[0] if same else i, []).append(held[i])
    return Positions(axis, tuple(map(tuple, groups.values())), attitude[list(groups)])


def _not_determined(evidence: AhrsEvidence, channel: int, positions: Positions) -> Message | None:
    """Why eq. (16) cannot be taken of these positions, None where it can."""
    count = len(positions.groups)
    if not count:
        return message("jjf1536-no-position")
    if positions.attitude is None:
        return None if count >= FEWEST_POSITIONS else message("jjf1536-few-positions", count=count)
    limit = np.full(COMPONENTS, CANCELS)
    if evidence.earth_in_attitude is not None:
        limit[:3] = TAKEN_OFF
    left = positions.attitude[:, channel].mean(axis=0)
    if np.linalg.norm(left / limit) <= 1.0:
        return None
    percent = f"{100 * float(np.linalg.norm(left)):.0f}"
    return message("jjf1536-earth-remains", count=count, percent=percent)


def _mean(
    evidence: AhrsEvidence, channel: int, positions: Positions, errors: EquipmentErrors
) -> tuple[Estimate, float]:
    """B (rad/s), and how much more than noise and equipment explain the positions differ.

    Every position counts once, so that Earth's rotation cancels; with one time T for all this is
    ΣN/(n·T). What crooked mounts leave of it is taken off where they are stated.
    """
    average = np.zeros((len(positions.groups), len(evidence.segments)))
    for row, group in zip(average, positions.groups, strict=True):
        row[list(group)] = 1.0 / len(group)
    excess, left, attitude = BirgeRatio(), 0.0, positions.attitude
    if attitude is not None:
        readings = average[:, positions.rests] @ evidence.means[positions.rests, channel]
        if evidence.earth_in_attitude is not None:
            felt = attitude[:, channel] @ evidence.earth_in_attitude
            readings, left = readings - felt, float(felt.mean())
        known = evidence.covariance(channel) + errors.covariance(channel)
        covariance = average @ known @ average.T
        for other in np.delete(attitude, channel, axis=1).swapaxes(0, 1):
            covariance += (COUPLING * EARTH_RATE) ** 2 * other @ other.T
        # What gravity does to a gyro follows the attitude, too, and cancels as Earth's rotation.
        columns = np.hstack([attitude[:, channel], attitude[:, :, VERTICAL]])
        columns = columns[:, np.abs(columns).max(axis=0) > ALONG]
        design = np.column_stack([np.ones(len(readings)), columns])
        excess = birge_ratio(solve(design), design, readings, covariance)
    mean = linear_estimate(evidence, channel, average.mean(axis=0), excess)
    repeated = tuple(map(float, excess.factor * u_of_means(evidence, channel, average)))
    mean = replace(mean, value=mean.value - left, repeated=repeated, without_earth=left != 0.0)
    return mean, excess.factor


def _remarks(evidence: AhrsEvidence, positions: Positions) -> Iterator[Remark]:
    """Conditions of 7.2.1 and 7.2.2: labels, number of positions, time at each."""
    axis, count = positions.axis, len(positions.groups)
    held = {i: evidence.segments[i] for i in positions.rests}
    labels = [segment.segment for segment in held.values()]
    if names := tuple(s.name for s in labels if attitude_contradicted(evidence.recording, s)):
        text = message("jjf1536-attitude-contradicted", axis=axis, segments=names)
        yield remark("pointing_contradicted", text, names, blocks_pass=True)
    if positions.attitude is None:
        text = message("jjf1536-attitude-not-recorded", axis=axis, count=count)
        yield remark("pointing_not_recorded", text, blocks_pass=True)
    if count < FEWEST_POSITIONS:
        text = message("jjf1536-number-of-positions", axis=axis, count=count)
        yield remark("number_of_positions", text, blocks_pass=True)
    asked = DWELL_S[4] if count <= FEWEST_POSITIONS else DWELL_S[12]
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
