"""What the reference says of the motion: a coarse encoder, or poses of a tracked body."""

import numpy as np

from schemas.recording import Stream
from tests.proof.plant.plan import Plan
from tests.proof.plant.rotations import about, from_vector, inverse, product, turned, vector_of
from tests.proof.plant.rough.case import Encoder, RoughCase, Tracking
from tests.proof.plant.rough.runs import ByHand
from tests.proof.plant.sampling import at_times
from tests.proof.plant.seeds import generator
from tests.proof.plant.world import Motion

UP = np.array([0.0, 0.0, 1.0])
BAND = 10.0  # Hz: what a reference's noise does above it, anyone smooths away
POSE = ("qw", "qx", "qy", "qz")
PLACE = ("px", "py", "pz")
LEAST = 1e-6  # s between two stamps


def scattered(rng: np.random.Generator, t: np.ndarray, jitter: float) -> np.ndarray:
    """Stamps (n,) s that scatter about true instants, still rising."""
    stamps = t + jitter * rng.standard_normal(len(t)) if jitter else t.copy()
    order = np.arange(len(t)) * LEAST
    return np.asarray(np.maximum.accumulate(stamps - order) + order)


def read_encoder(rough: RoughCase, encoder: Encoder, plan: Plan, reported: Motion) -> Stream:
    """The table's stream: angles in steps, at the encoder's own rate and stamps."""
    rng = generator(rough.case.seed, "rough encoder")
    t = np.arange(0.0, plan.duration, 1.0 / encoder.rate_hz)
    true = at_times(reported.shaft, float(reported.t[0]), reported.step, t)
    stamps = scattered(rng, t, encoder.jitter)
    columns = {}
    for name, angle in zip(plan.table.names, true, strict=True):
        noisy = angle + encoder.noise * rng.standard_normal(len(t))
        read = np.round(noisy / encoder.step) * encoder.step
        columns[f"{name}_angle"] = read
        if encoder.speeds:
            columns[f"{name}_rate"] = np.gradient(read) * encoder.rate_hz
    return Stream(stamps, columns)


def track(rough: RoughCase, tracking: Tracking, hand: ByHand, rows: np.ndarray) -> Stream:
    """The stream of poses, at the frames' own stamps or at the unit's `rows` (n,) s."""
    rng = generator(rough.case.seed, "tracking")
    t = np.arange(0.0, rough.duration_s, 1.0 / tracking.rate_hz)
    start, step = float(hand.t[0]), float(hand.t[1] - hand.t[0])
    attitude = at_times(hand.attitude, start, step, t - tracking.delay)
    place = at_times(hand.place, start, step, t - tracking.delay)
    error = tracking.attitude_noise * rng.standard_normal((3, len(t)))
    attitude = product(attitude / np.linalg.norm(attitude, axis=0), from_vector(error))
    attitude = product(attitude, inverse(from_vector(np.array(tracking.turn))))
    tilt = from_vector(np.array(tracking.tilt))
    attitude = product(tilt, attitude)
    place = turned(tilt, place + tracking.position_noise * rng.standard_normal(place.shape))
    poses = np.concatenate([attitude, place])
    observation = np.ones(len(t), dtype=bool)
    for begin, end in tracking.gaps:
        observation &= (t < begin) | (t > end)
    t, poses = t[observation], poses[:, observation]
    if tracking.interpolated:
        t, poses = _between(t, poses, rows, tracking)
    poses[:4] /= np.linalg.norm(poses[:4], axis=0)
    return Stream(t, dict(zip(POSE + PLACE, poses, strict=True)))


def _between(
    t: np.ndarray, poses: np.ndarray, rows: np.ndarray, tracking: Tracking
) -> tuple[np.ndarray, np.ndarray]:
    """Poses in straight lines between frames at the unit's rows; none where nothing was seen."""
    inside = (rows >= t[0]) & (rows <= t[-1])
    for begin, end in tracking.gaps:
        inside &= (rows < begin) | (rows > end)
    return rows[inside], np.stack([np.interp(rows[inside], t, series) for series in poses])


def misread(rough: RoughCase, plan: Plan, recorded: Stream, motion: Motion, t: np.ndarray,
            place: np.ndarray | None = None) -> np.ndarray:  # fmt: skip
    """What the reference's noise adds to predicted rates and specific force: (6, n) at t (n,) s.

    The error of attitude (and of position) up to 10 Hz, differentiated; what the case tells as
    turn, tilt and delay is no noise and counts nothing. place: true positions (3, n) m at t.
    """
    step = float(t[1] - t[0])
    true = _unit(at_times(motion.attitude, float(motion.t[0]), motion.step, t))
    force = at_times(motion.force, float(motion.t[0]), motion.step, t)
    if rough.tracking is None:
        response = _from_shaft(rough, plan, recorded, t)
        moved = np.zeros((3, len(t)))
    else:
        response, moved = _from_poses(rough.tracking, recorded, t, place)
        moved = _second(_smooth(moved, step), step)
    error = vector_of(_short(product(inverse(true), response)))
    error = _smooth(error - np.median(error, axis=1, keepdims=True), step)
    rates = np.gradient(error, step, axis=1)
    return np.concatenate([rates, np.cross(force, error, axis=0) + turned(inverse(true), moved)])


def _from_shaft(rough: RoughCase, plan: Plan, recorded: Stream, t: np.ndarray) -> np.ndarray:
    response = about(UP, -np.radians(rough.case.heading_deg))
    for name, direction in zip(plan.table.names, plan.table.directions, strict=True):
        angle = np.interp(t, recorded.t, recorded.columns[f"{name}_angle"])
        response = product(response, about(np.array(direction), angle))
    return product(response, np.array(plan.mounts[0]).reshape(4, 1))


def _from_poses(
    tracking: Tracking, recorded: Stream, t: np.ndarray, place: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Attitude (4, n) and error of position (3, n) m, freed of what is told of the tracking."""
    columns = [recorded.columns[name] for name in POSE + PLACE]
    late = t + tracking.delay
    poses = np.stack([np.interp(late, recorded.t, column) for column in columns])
    upright = inverse(from_vector(np.array(tracking.tilt)))
    response = product(product(upright, _unit(poses[:4])), from_vector(np.array(tracking.turn)))
    where = turned(upright, poses[4:])
    return response, where - (where if place is None else place)


def _unit(q: np.ndarray) -> np.ndarray:
    return np.asarray(q / np.linalg.norm(q, axis=0))


def _short(q: np.ndarray) -> np.ndarray:
    return np.asarray(np.where(q[0] < 0.0, -q, q))


def _smooth(series: np.ndarray, step: float) -> np.ndarray:
    """Courses (…, n) without what lies above the band, a soft edge."""
    ends = [(0, 0)] * (series.ndim - 1) + [(0, series.shape[-1])]
    spectrum = np.fft.rfft(np.pad(series, ends, mode="symmetric"))
    frequency = np.fft.rfftfreq(2 * series.shape[-1], step)
    passed = np.fft.irfft(spectrum / (1.0 + (frequency / BAND) ** 8), 2 * series.shape[-1])
    return np.asarray(passed[..., : series.shape[-1]])


def _second(series: np.ndarray, step: float) -> np.ndarray:
    return np.asarray(np.gradient(np.gradient(series, step, axis=-1), step, axis=-1))
