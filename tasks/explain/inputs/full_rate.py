"""A recording at the unit's own rows: readings, motion, segments and the noise of samples."""

from dataclasses import dataclass, replace

import numpy as np

from schemas.base import Unusable
from schemas.recording import Recording, Segment
from tasks.explain.channels import CHANNELS
from tasks.explain.inputs.gyro_acceleration import with_gyro_acceleration
from tasks.explain.inputs.labels import with_usable_labels
from tasks.explain.inputs.recorded_signals import recorded_signals
from tasks.explain.inputs.remarks import clock_remarks, reference_remarks
from tasks.explain.inputs.sample_noise import noise_by_segment, output_steps, vibration
from tasks.explain.inputs.seen_places import with_seen_places
from tasks.motion.reference_noise import EXACT, ReferenceNoise, reference_noise
from tasks.motion.whole import Motion, whole_motion
from tasks.segments.find import find_segments
from tasks.words import Sayable

TURNING = 0.1  # rad/s: what turns so much does not rest, whatever the noise of its poses
NEAR_LEAST = 1.3  # times the least variance of a segment: still at rest


@dataclass(frozen=True)
class FullRate:
    """The recording at the unit's own rows: readings (n, 6), and the motion with recorded signals.

    segment: (n,) index into `segments`, −1 between them. segment_variance: (segments + 1, 2) noise
    variance of a sample in each, by triad; last: between them. steps: (6,) of the outputs;
    dithered: (6,) bool, noise is larger, so that means are finer than steps. start: of the motion's
    t = 0 on the recording's own clock, s. remarks: on the reference. reference_noise: errors of its
    predictions. span: s over which each row is a mean.
    """

    readings: np.ndarray
    motion: Motion
    segment: np.ndarray
    segments: tuple[Segment, ...]
    segment_variance: np.ndarray
    steps: np.ndarray
    dithered: np.ndarray
    start: float = 0.0
    remarks: tuple[Sayable, ...] = ()
    reference_noise: ReferenceNoise = EXACT
    span: float = 0.0

    @property
    def rest_variance(self) -> np.ndarray:
        """(6,) variance of a sample's noise at rest, of one triad the same; 1 if not known."""
        known = np.where(np.isfinite(self.segment_variance), self.segment_variance, np.inf)
        usual = [_median(variances) for variances in self.segment_variance.T]
        rounding = self.steps.reshape(2, 3).max(axis=1) ** 2 / 12.0
        level = np.maximum(np.minimum(usual, NEAR_LEAST * known.min(axis=0)), rounding)
        return np.where(np.isfinite(level) & (level > 0), level, 1.0).repeat(3)


def full_rate(recording: Recording) -> FullRate:
    """Motion and readings at the unit's rows.

    Raises Unusable if the recording has no rates and forces, or does not show the motion.
    """
    name = recording.manifest.recording_id
    if not set(CHANNELS) & set(recording.imu.columns):
        raise Unusable(
            f"recording {name} has no gyro_* or accel_* columns; "
            "explain needs rates or specific forces"
        )
    readings = recording.imu.stack(CHANNELS)
    recording, on_labels = with_usable_labels(recording)
    motion = with_seen_places(recording, whole_motion(recording))
    motion = with_gyro_acceleration(motion, readings)
    if not motion.felt.any():
        raise Unusable(
            f"recording {name} does not show how the unit moved: it has no table stream with "
            "table_axes, no reference pose and no labelled segments; add one of them"
        )
    # A motion that is unknown in places (labels only) must not reach into its neighbours.
    segments = recording.manifest.segments or _found_segments(recording, motion)
    segment = np.full(len(motion.t), -1)
    for k, each in enumerate(segments):
        segment[recording.imu.rows(each.t_start, each.t_end)] = k
    variance = noise_by_segment(readings, motion, segment, len(segments))
    remarks = (*on_labels, *reference_remarks(recording, motion), *clock_remarks(recording))
    speed = np.linalg.norm(np.nan_to_num(motion.rate), axis=1)
    recorded = recorded_signals(recording, motion.t, segments)
    recorded["vibration"] = vibration(variance, segment, speed)
    start = float(motion.t[0])
    noise = reference_noise(recording, motion).since(start)
    motion = replace(motion, t=motion.t - start, recorded=recorded)
    return FullRate(
        readings, motion, segment, segments, variance, *output_steps(readings), start, remarks,
        noise, recording.imu.span,
    )  # fmt: skip


def _found_segments(recording: Recording, motion: Motion) -> tuple[Segment, ...]:
    """Segments without labels; no rest where poses turn, as they show better than the readings."""
    segments = find_segments(recording)
    if motion.tracking is None:
        return segments
    turns = np.linalg.norm(motion.rate, axis=1)
    kept = []
    for each in segments:
        own = turns[recording.imu.rows(each.t_start, each.t_end)]
        own = own[np.isfinite(own)]
        if each.kind != "static" or not (len(own) and np.sqrt((own**2).mean()) > TURNING):
            kept.append(each)
    return tuple(kept)


def _median(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else np.inf
