"""The evidence of a recording for JJF 1536: its segments summarised and sorted."""

from dataclasses import replace

import numpy as np

from schemas.base import Unusable
from schemas.recording import ACCEL, ANGLE, AXES, MEASURED, Recording, Up
from tasks.segments.find import find_segments, up_of
from tasks.segments.rates import turning_points
from tasks.segments.summarise import (
    ACCEL_COLUMNS,
    CHANNELS,
    MIN_ROWS,
    Origin,
    SegmentMean,
    rows_of,
    summarise_all,
)
from tasks.segments.units import wrong_rate_unit
from tasks.specifications.evidence import UPS
from tasks.specifications.jjf1536.angles import as_rates, has_angles, summarise_angles
from tasks.specifications.jjf1536.attitudes import (
    attitude_contradicted,
    attitude_vector,
    with_attitude,
)
from tasks.specifications.jjf1536.evidence import SCALE_ITEMS, AhrsEvidence, reads_another_rate
from tasks.specifications.jjf1536.turned import rate_in_the_middle, turned_angle
from tasks.uncertainty.type_a import fit_noise


def gather_ahrs(recording: Recording) -> AhrsEvidence:
    """Summarise a recording's segments, labelled or found, and sort them.

    Raises Unusable where rates and labels are in different units.
    """
    by_angle = has_angles(recording)
    rates = as_rates(recording) if by_angle else recording
    labels = recording.manifest.segments
    origin: Origin = "label" if labels else "found"
    wanted = labels or find_segments(rates)
    wanted = tuple(s for s in wanted if rows_of(rates, s) >= MIN_ROWS)
    measured = tuple(s for s in wanted if s.kind in MEASURED)
    segments: tuple[SegmentMean, ...] = ()
    noise, coarse = np.zeros(3), False
    if by_angle and measured:
        segments, angles, coarse = summarise_angles(recording, rates, measured, origin)
        noise = angles.angle
    elif measured:
        segments = summarise_all(rates, measured, origin)
    segments = tuple(s for s in segments if s.has_gyro)
    wrong = wrong_rate_unit(segments, *(("angle columns", "rad") if by_angle else ()))
    if wrong is not None:
        raise Unusable(f"{recording.manifest.recording_id}: {wrong}")
    evidence = _sorted(rates, segments, noise)
    if not by_angle:
        return evidence
    names = (*ANGLE, *ACCEL)
    return replace(evidence, by_angle=True, channel_names=names, may_stand_still=coarse)


def _sorted(rates: Recording, segments: tuple[SegmentMean, ...], noise: np.ndarray) -> AhrsEvidence:
    points = turning_points(rates, segments)
    everything = range(len(segments))
    rate = np.array([points[i].rate if i in points else np.nan for i in everything])
    read = [
        np.isfinite(rate[i]) and not reads_another_rate(segments[i], rate[i]) for i in everything
    ]
    attitudes = tuple(
        attitude_vector(rates, s.segment) if s.segment.kind == "static" else None for s in segments
    )
    up = tuple(_up(s, vector) for s, vector in zip(segments, attitudes, strict=True))
    rests = [i for i in everything if segments[i].segment.kind == "static"]
    labels = [segment.segment for segment in segments]
    for_noise = tuple(
        _for_noise(s, vector, points[i].rate if i in points else None)
        for i, (s, vector) in enumerate(zip(segments, attitudes, strict=True))
    )
    turns = {axis: tuple(i for i in everything if labels[i].axis == axis
                         and (labels[i].kind == "rotation" or (labels[i].kind == "rate"
                              and labels[i].item == "misalignment"))) for axis in AXES}  # fmt: skip
    turning = [i for axis in AXES for i in turns[axis]]
    return AhrsEvidence(
        recording=rates,
        segments=segments,
        means=np.array([segment.mean for segment in segments]).reshape(-1, len(CHANNELS)),
        noise=fit_noise(for_noise),
        up=up,
        positions={u: tuple(i for i in rests if up[i] == u) for u in UPS},
        points={axis: tuple(i for i in everything if labels[i].kind == "rate"
                            and labels[i].axis == axis and labels[i].item != "misalignment"
                            and read[i]) for axis in AXES},
        rate=rate,
        turns=turns,
        rests={u: tuple(i for i in rests if up[i] == u and labels[i].item in (None, *SCALE_ITEMS))
               for u in UPS},
        turning_points=points,
        attitude=attitudes,
        contradicted=frozenset(i for i in rests if attitude_contradicted(rates, labels[i])),
        turned={i: turned_angle(rates, labels[i]) for i in turning},
        turn_rate={i: rate_in_the_middle(rates, labels[i]) for i in turning},
        angle_noise=noise,
        by_angle=False,
    )  # fmt: skip


def _for_noise(segment: SegmentMean, vector: np.ndarray | None, rate: float | None) -> SegmentMean:
    """A summary with what its place and rate really were, by which drift is recognised.

    A turn whose rate is not known says nothing of drift; nor does a triad that was not recorded.
    """
    label = with_attitude(segment.segment, vector)
    if rate is not None:
        known = {"rate_deg_s": float(np.degrees(rate))} if np.isfinite(rate) else {"up": None}
        label = label.model_copy(update=known)
    return replace(segment, segment=label, allan=np.nan_to_num(segment.allan))


def _up(segment: SegmentMean, vector: np.ndarray | None) -> Up | None:
    """The axis up: what gravity shows in a rest, else the label, else the attitude."""
    label = segment.segment
    if label.kind == "static" and segment.has_accel:
        return up_of(segment.mean[ACCEL_COLUMNS])
    return label.up or with_attitude(label, vector).up
