"""A body moved by hand, by plain formulas: turned about the room's vertical, then about its own x
axis, while it is carried about; and its poses as a tracker sees them."""

from dataclasses import dataclass

import numpy as np

from schemas.recording import Recording, Stream
from tests.manifests import manifest_of

GRAVITY = 9.81
SECONDS, RATE, FRAMES = 60.0, 200.0, 120.0  # s, Hz, Hz
# amplitude, frequency in Hz, phase
YAW = ((0.9, 0.21, 0.3), (0.35, 0.63, 1.1), (0.12, 1.1, 2.0))
ROLL = ((0.7, 0.17, 1.9), (0.4, 0.71, 0.2), (0.1, 1.2, 1.0))
PLACES = (
    ((0.4, 0.19, 0.0), (0.08, 0.77, 1.0), (0.02, 1.3, 0.5)),
    ((0.3, 0.23, 1.2), (0.09, 0.66, 0.4), (0.02, 1.2, 2.5)),
    ((0.2, 0.13, 2.1), (0.07, 0.91, 1.6), (0.02, 1.1, 0.9)),
)


@dataclass(frozen=True)
class ByHand:
    """What happened at t (n,) s: vectors (n, 3) in the body, place in the room (m), attitude
    as a quaternion (n, 4), scalar first."""

    t: np.ndarray
    up: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray
    translation: np.ndarray
    place: np.ndarray
    attitude: np.ndarray


def waves(parts, t, order=0):
    """Sum of sines, or its first or second derivative."""
    shift = 0.5 * np.pi * order
    return sum(a * (2 * np.pi * f) ** order * np.sin(2 * np.pi * f * t + p + shift)
               for a, f, p in parts)  # fmt: skip


def by_hand(t: np.ndarray, moving: bool = True) -> ByHand:
    """The body at times t; it turns, and is carried about where it is `moving`."""
    (psi, dpsi, ddpsi), (phi, dphi, ddphi) = (
        [waves(parts, t, order) for order in range(3)] for parts in (YAW, ROLL)
    )
    zero, sin, cos = np.zeros_like(t), np.sin(phi), np.cos(phi)
    up = np.column_stack([zero, sin, cos])
    rate = np.column_stack([dphi, dpsi * sin, dpsi * cos])
    change = np.column_stack([
        ddphi, ddpsi * sin + dpsi * dphi * cos, ddpsi * cos - dpsi * dphi * sin
    ])  # fmt: skip
    place = np.column_stack([waves(parts, t) for parts in PLACES]) * moving
    pushed = np.column_stack([waves(parts, t, 2) for parts in PLACES]) * moving
    level = np.column_stack([  # turned back by the yaw
        np.cos(psi) * pushed[:, 0] + np.sin(psi) * pushed[:, 1],
        -np.sin(psi) * pushed[:, 0] + np.cos(psi) * pushed[:, 1],
        pushed[:, 2],
    ])  # fmt: skip
    inside = np.column_stack([  # and by the roll
        level[:, 0], cos * level[:, 1] + sin * level[:, 2], cos * level[:, 2] - sin * level[:, 1]
    ])  # fmt: skip
    half_psi, half_phi = 0.5 * psi, 0.5 * phi
    attitude = np.column_stack([
        np.cos(half_psi) * np.cos(half_phi), np.cos(half_psi) * np.sin(half_phi),
        np.sin(half_psi) * np.sin(half_phi), np.sin(half_psi) * np.cos(half_phi),
    ])  # fmt: skip
    return ByHand(t, up, rate, change, inside, place, attitude)


def turned_a_little(attitude: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Quaternions (n, 4) followed by small rotation vectors (n, 3), to first order."""
    w, xyz = attitude[:, :1], attitude[:, 1:]
    more = np.hstack([
        w - 0.5 * (xyz * vector).sum(axis=1, keepdims=True),
        xyz + 0.5 * (w * vector + np.cross(xyz, vector)),
    ])  # fmt: skip
    return more / np.linalg.norm(more, axis=1, keepdims=True)


def poses(
    seed: int = 1, turn_noise: float = 2e-4, place_noise: float = 5e-5, frames: float = FRAMES,
    delay: float = 0.0, seconds: float = SECONDS, places: bool = True,
) -> Stream:  # fmt: skip
    """What a tracker says: at t where the body was `delay` s before, with white noise."""
    rng, t = np.random.default_rng(seed), np.arange(0.0, seconds, 1.0 / frames)
    observed = by_hand(t - delay)
    error = turn_noise * rng.standard_normal((len(t), 3))
    columns = dict(
        zip(("qw", "qx", "qy", "qz"), turned_a_little(observed.attitude, error).T, strict=True)
    )
    if places:
        found = observed.place + place_noise * rng.standard_normal((len(t), 3))
        columns |= dict(zip(("px", "py", "pz"), found.T, strict=True))
    return Stream(t, columns)


def readings(
    seed: int = 2, gyro_noise: float = 1e-3, accel_noise: float = 0.02, arm=(0.0, 0.0, 0.0),
    seconds: float = SECONDS, moving: bool = True,
) -> Stream:  # fmt: skip
    """What an ideal unit reads whose accelerometers sit `arm` (m) from the tracked origin."""
    rng, t = np.random.default_rng(seed), np.arange(0.0, seconds, 1.0 / RATE)
    true, arm = by_hand(t, moving), np.array(arm)
    force = GRAVITY * true.up + true.translation + np.cross(true.acceleration, arm)
    force += np.cross(true.rate, np.cross(true.rate, arm))
    rates = true.rate + gyro_noise * rng.standard_normal((len(t), 3))
    force += accel_noise * rng.standard_normal((len(t), 3))
    columns = {f"gyro_{a}": c for a, c in zip("xyz", rates.T, strict=True)}
    return Stream(t, columns | {f"accel_{a}": c for a, c in zip("xyz", force.T, strict=True)})


def recording(imu: Stream | None = None, reference: Stream | None = None, **more) -> Recording:
    """A recording with a tracked body and nothing else."""
    manifest = manifest_of("by_hand", **{"station": {"gravity_m_s2": GRAVITY}} | more)
    return Recording(manifest, imu or readings(), reference=reference or poses())


def tilted(reference: Stream, angle: float) -> Stream:
    """The same poses in a room that leans by an angle (rad) about its x axis."""
    columns = dict(reference.columns)
    w, x, y, z = (columns[name] for name in ("qw", "qx", "qy", "qz"))
    c, s = np.cos(0.5 * angle), np.sin(0.5 * angle)
    columns |= {"qw": c * w - s * x, "qx": c * x + s * w, "qy": c * y - s * z, "qz": c * z + s * y}
    y, z, c, s = columns["py"], columns["pz"], np.cos(angle), np.sin(angle)
    columns |= {"py": c * y - s * z, "pz": s * y + c * z}
    return Stream(reference.t, columns)
