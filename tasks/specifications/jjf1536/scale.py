"""7.1: scale factor by least squares over the rate points, eq. (10) to (15)."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from schemas.recording import AXES, Axis
from schemas.text import Remark
from tasks.specifications.error_sources import EquipmentErrors
from tasks.specifications.estimate import (
    ClauseResult,
    Estimates,
    ItemEstimate,
    MeansFit,
    item_by_axis,
    linear_estimate,
    undetermined,
)
from tasks.specifications.jjf1536.evidence import AhrsEvidence, reads_another_rate
from tasks.specifications.linear import BLOCKING_EXCESS
from tasks.specifications.rates import distinct_rates, fit_line, rate_remarks, weights_about
from tasks.words import Message, message, remark

CLAUSE = "JJF 1536-2015, 7.1.2 eq. (10)-(15)"
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

    item = ItemEstimate(undetermined(AXES), CLAUSE, readings)
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
