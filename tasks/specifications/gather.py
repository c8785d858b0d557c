"""The evidence of a recording for JJF 2003: its segments summarised and sorted."""

from dataclasses import replace

import numpy as np

from schemas.recording import AXES, Recording, Up
from tasks.motion.table import EARTH_RATE
from tasks.motion.whole import unit_vector
from tasks.readings.stamps import with_instants
from tasks.segments.find import GRAVITY_LIKE, find_segments, up_of
from tasks.segments.rates import turning_points
from tasks.segments.summarise import (
    ACCEL_COLUMNS,
    MIN_ROWS,
    SegmentMean,
    rows_of,
    summarise_all,
)
from tasks.specifications.earth_gain import EarthRotationGain
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.linear import birge_ratio, solve
from tasks.uncertainty.type_a import fit_noise


def gather(recording: Recording) -> ClauseEvidence:
    """Summarise a recording's segments, labelled or found, and sort them."""
    recording = with_instants(recording)
    labels = recording.manifest.segments
    if labels:
        long_enough = tuple(s for s in labels if rows_of(recording, s) >= MIN_ROWS)
        segments = summarise_all(recording, long_enough, "label")
    else:
        segments = summarise_all(recording, find_segments(recording), "found")
    points = turning_points(recording, segments)
    rate = np.array([points[i].rate if i in points else np.nan for i in range(len(segments))])
    up = tuple(_up(segment) for segment in segments)
    evidence = ClauseEvidence(
        recording=recording,
        segments=segments,
        means=np.array([segment.mean for segment in segments]).reshape(-1, 6),
        noise=fit_noise(segments, up, rate),
        up=up,
        rate=rate,
        turning_points=points,
    )
    return replace(evidence, earth=earth_rotation_gain(evidence))


def _up(segment: SegmentMean) -> Up | None:
    """The axis up: what gravity shows, else the label; None where gravity shows no axis.

    While turning, only what is felt along the spin axis is gravity: a lever arm adds its own
    acceleration across it.
    """
    label = segment.segment
    found_rest = segment.origin == "found" and label.kind == "static"
    if found_rest or not segment.has_accel or label.kind == "rotation":
        return label.up
    accel = segment.mean[ACCEL_COLUMNS]
    if label.kind != "rate" or label.axis is None:
        return up_of(accel)
    along = accel[AXES.index(label.axis)]
    if not GRAVITY_LIKE[0] < abs(along) < GRAVITY_LIKE[1]:
        return None
    return f"{'+' if along > 0 else '-'}{label.axis}"  # type: ignore[return-value]


def earth_rotation_gain(evidence: ClauseEvidence) -> EarthRotationGain | None:
    """λ by least squares over the rests; None without a latitude, or where no rest determines it.

    Where north is known in the rests: for each gyro, bias, three g-sensitivities and λ times the
    north component of Earth's rate; the vertical part cannot be separated from the g-sensitivity
    and does not count. Else: (up − down)/2 over ωe·sin φ, as if the g-sensitivity were none. The
    gyros together by their weights; where they disagree u is enlarged. A scale factor of 1 is
    taken.
    """
    rests = [
        i
        for i in evidence.of_kind("static")
        if evidence.segments[i].has_gyro and evidence.up[i] is not None
    ]
    if evidence.latitude_deg is None or not rests:
        return None
    phi = np.radians(evidence.latitude_deg)
    up = np.array([unit_vector(evidence.up[i]) for i in rests])
    north = evidence.north[rests]
    level = bool(np.isfinite(north).all())
    earth = np.cos(phi) * north if level else np.sin(phi) * up
    return gain_over(evidence, rests, up, earth, level)


def gain_over(
    evidence: ClauseEvidence, rests: list[int], up: np.ndarray, earth: np.ndarray, level: bool
) -> EarthRotationGain | None:
    """λ over some rests; up, earth: (rests, 3) the vertical, and the part of Earth's rotation."""
    by_gyro = [_of_gyro(evidence, rests, up, EARTH_RATE * earth, c, level) for c in range(3)]
    gains = np.array([gain for gain in by_gyro if gain is not None])
    if not len(gains):
        return None
    weights = 1.0 / gains[:, 1] ** 2
    mean = float(weights @ gains[:, 0] / weights.sum())
    square = float(weights @ (gains[:, 0] - mean) ** 2) / max(len(gains) - 1, 1)
    return EarthRotationGain(mean, float(np.sqrt(max(square, 1.0) / weights.sum())), level)


def steady_gain(
    evidence: ClauseEvidence, rests: list[int], attitude: np.ndarray, level: float
) -> EarthRotationGain | None:
    """How much of Earth's level rotation (rad/s) rests show, along whatever level direction.

    attitude: (rests, 3, 3) axes of the unit along east, north and up. A wrong heading shows all of
    it along another one.
    """
    east, north, up = np.moveaxis(attitude, 2, 0)
    parts = [
        gain_over(evidence, rests, up, level / EARTH_RATE * part, True) for part in (north, east)
    ]
    if parts[0] is None or parts[1] is None:
        return None
    return EarthRotationGain(float(np.hypot(parts[0].gain, parts[1].gain)), parts[0].u, True)


def _of_gyro(
    evidence: ClauseEvidence,
    rests: list[int],
    up: np.ndarray,
    earth: np.ndarray,
    gyro: int,
    level: bool,
) -> tuple[float, float] | None:
    """λ and u of one gyro; None where its rests do not determine it."""
    bias, rate = np.ones(len(rests)), earth[:, gyro]
    columns = (bias, *up.T, rate) if level else (bias, rate)
    if not level:
        rests = [i for i, on in zip(rests, rate, strict=True) if on]
        columns = (bias[rate != 0.0], rate[rate != 0.0])
    design = np.column_stack(columns)
    if not len(design):
        return None
    solution = solve(design)
    readings = evidence.means[rests, gyro]
    covariance = evidence.covariance(gyro)[np.ix_(rests, rests)]
    u = float(solution.uncertainty(covariance)[-1])
    u *= birge_ratio(solution, design, readings, covariance).factor
    value = float(solution.of(readings)[-1])
    return (value, u) if np.isfinite(value) and u > 0.0 else None
