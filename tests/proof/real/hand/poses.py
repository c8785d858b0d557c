"""A unit on a tracked body, by hand: delay, turn, lever arm and vertical, by least squares.

The noisy poses stand on the left: their rates and the second differences of their positions are
fitted by what the unit's own readings make of them, so that no noise of the poses is in a
regressor. Both sides are differenced and filtered by the very same operators, which then bias
nothing. Each part of the recording is fitted by itself, in several bands: their scatter is u.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar
from scipy.signal import butter, sosfiltfilt
from scipy.spatial.transform import Rotation, RotationSpline

from schemas.recording import ACCEL, GYRO, Recording
from tests.proof.real.hand.measured import Measured

GAP = 3.5  # intervals between frames that belong together
SLOW, FAST = (3.0, 4.0, 5.0, 6.0), (4.0, 6.0, 8.0, 10.0)  # Hz: bands that are tried
FAST_FRAMES = 1.0 / 50.0  # s between frames
FINEST = 0.01  # s between frames that are used
SHORTEST = 3.0  # s of a stretch without a gap
EDGE = 0.5  # s at either end of a stretch, where the filter still settles
PARTS = 4  # of a recording, each fitted by itself
MOST = 0.1  # s, lag
NEAR = 1.5e-3  # s, of delays that differ
# Usual sizes: errors of the accelerometers' matrix, biases m/s², lever arm m, lean rad.
USUAL = np.array([0.02] * 9 + [0.5] * 3 + [1.0] * 3 + [0.02] * 2)
POSE, PLACE = ("qw", "qx", "qy", "qz"), ("px", "py", "pz")
NAMES = ("r_x", "r_y", "r_z")


@dataclass(frozen=True)
class Stretch:
    """Frames without a gap: t (n,) s even, attitude of the body in the room, place (n, 3) m."""

    t: np.ndarray
    attitude: Rotation
    place: np.ndarray | None


@dataclass(frozen=True)
class OnBody:
    """delay: s by which the readings are late. turn: of the unit in the body, degrees about its
    axes (3,). lever: (3,) m from the tracked point to the accelerometers, along the unit's axes.
    lean: (2,) degrees of the vertical about x and y of the room. left: rad/s and m/s², root mean
    square of what is left of rates and accelerations.
    """

    delay: float
    turn: np.ndarray
    lever: np.ndarray
    lean: np.ndarray
    left: tuple[float, float]


def spans_of(recording: Recording) -> list[Stretch]:
    """Those that are long enough, put on an even grid of the frames' interval."""
    pose = recording.reference
    assert pose is not None
    interval = float(np.median(np.diff(pose.t)))
    cuts = np.flatnonzero(np.diff(pose.t) > GAP * interval) + 1
    found = []
    for a, b in pairwise([0, *cuts.tolist(), len(pose.t)]):
        if b - a < 8 or pose.t[b - 1] - pose.t[a] < SHORTEST:
            continue
        own, t = pose.at(slice(a, b)), np.arange(pose.t[a], pose.t[b - 1], max(interval, FINEST))
        attitude = Rotation.from_quat(own.stack(POSE), scalar_first=True)
        place = (
            CubicSpline(own.t, own.stack(("px", "py", "pz")))(t) if "px" in own.columns else None
        )
        found.append(Stretch(t, RotationSpline(own.t, attitude)(t), place))
    return found


def on_body(recording: Recording, edge: float, part: tuple[float, float] = (0.0, 1.0)) -> OnBody:
    """The fit below `edge` Hz to a part of the recording, from and to as shares of its time."""
    whole = spans_of(recording)
    t0, t1 = whole[0].t[0], whole[-1].t[-1]
    low, high = t0 + part[0] * (t1 - t0), t0 + part[1] * (t1 - t0)
    fit = _Fit(recording, whole, edge, low, high)
    delay = float(
        minimize_scalar(
            lambda lag: fit.rates(lag)[0], bounds=(-MOST, MOST), method="bounded",
            options={"xatol": 1e-6},
        ).x
    )  # fmt: skip
    left, matrix, bias = fit.rates(delay)
    u, _, v = np.linalg.svd(matrix)
    turn = Rotation.from_matrix(u @ np.diag([1.0, 1.0, np.linalg.det(u @ v)]) @ v)
    if whole[0].place is None:
        nothing = np.full(3, np.nan)
        return OnBody(delay, turn.as_rotvec(degrees=True), nothing, nothing[:2], (left, np.nan))
    lever, lean, more = fit.forces(delay, matrix, bias)
    return OnBody(delay, turn.as_rotvec(degrees=True), turn.inv().apply(lever), lean, (left, more))


class _Fit:
    def __init__(
        self, recording: Recording, whole: Sequence[Stretch], edge: float, low: float, high: float
    ) -> None:
        imu = recording.imu
        self.whole, self.edge, self.low, self.high = whole, edge, low, high
        self.interval = float(whole[0].t[1] - whole[0].t[0])
        self.filter = butter(4, edge, fs=1.0 / self.interval, output="sos")
        self.gravity = recording.manifest.station.gravity_m_s2
        gyro, accel = imu.stack(GYRO), imu.stack(ACCEL)
        known = np.isfinite(gyro).all(axis=1) & np.isfinite(accel).all(axis=1)
        self.t = imu.t[known]
        self.gyro = CubicSpline(self.t, gyro[known])
        self.angle = self.gyro.antiderivative()
        self.accel = CubicSpline(self.t, accel[known])

    def rates(self, lag: float) -> tuple[float, np.ndarray, np.ndarray]:
        """What is left of the body's rates by the gyros' (rms), their matrix and bias."""
        left, right = [], []
        for one, rows in self._used(lag):
            turned = (one.attitude[:-1].inv() * one.attitude[1:]).as_rotvec() / self.interval
            read = np.diff(self.angle(one.t + lag), axis=0) / self.interval
            left.append(self._passed(turned)[rows[:-1]])
            right.append(self._passed(read)[rows[:-1]])
        A, y = np.vstack(right), np.vstack(left)
        A = np.column_stack([A, np.ones(len(A))])
        found = np.linalg.lstsq(A, y, rcond=None)[0]
        return float(np.sqrt(((y - A @ found) ** 2).mean())), found[:3].T, found[3]

    def forces(
        self, lag: float, matrix: np.ndarray, bias: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """Lever arm (3,) m along the body's axes, lean (2,) degrees, and what is left, m/s²."""
        left, right = [], []
        for one, rows in self._used(lag):
            fine = np.arange(one.t[0], one.t[-1], min(0.5 * self.interval, FINEST))
            attitude = RotationSpline(one.t, one.attitude)(fine).as_matrix()
            rate = self.gyro(fine + lag) @ matrix.T + bias
            bend = self.gyro(fine + lag, 1) @ matrix.T
            spin = _cross(bend) + _cross(rate) @ _cross(rate)
            read = self.accel(fine + lag)
            made = [
                *(attitude[:, :, i] * read[:, j, None] for i in range(3) for j in range(3)),
                *(attitude[:, :, i] for i in range(3)),
                *np.moveaxis(-np.einsum("nij,njk->nik", attitude, spin), 2, 0),
            ]
            columns = [self._as_differences(each, fine, one.t) for each in made]
            ones = np.ones(len(one.t))
            columns += [np.outer(ones, self.gravity * axis) for axis in np.eye(3)[:2]]
            assert one.place is not None
            bent = np.zeros((len(one.t), 3))
            bent[1:-1] = np.diff(one.place, 2, axis=0) / self.interval**2
            y = self._passed(bent) + self.gravity * np.array([0.0, 0.0, 1.0])
            left.append(y[rows].ravel())
            right.append(np.stack(columns, axis=2)[rows].reshape(-1, len(columns)))
        A, y = np.vstack(right), np.concatenate(left)
        u, _, v = np.linalg.svd(matrix)
        first = np.zeros(A.shape[1])
        first[:9] = (u @ v).ravel()
        y = y - A @ first
        # A body that hardly turns does not tell scale factors and biases: they are as of any unit.
        free = np.linalg.lstsq(A, y, rcond=None)[0]
        scatter = float((y - A @ free).std()) / np.sqrt(2.0 * self.edge * self.interval)
        known = np.linalg.lstsq(
            np.vstack([A, np.diag(scatter / USUAL)]), np.append(y, np.zeros(len(USUAL))), rcond=None
        )[0]
        lean = np.degrees(np.array([-known[16], known[15]]))
        return known[12:15], lean, float(np.sqrt(((y - A @ known) ** 2).mean()))

    def _as_differences(self, values: np.ndarray, fine: np.ndarray, t: np.ndarray) -> np.ndarray:
        """(n, 3) as second differences of positions show an acceleration; filtered as they are."""
        twice = CubicSpline(fine, values).antiderivative(2)
        seen = np.zeros((len(t), 3))
        seen[1:-1] = np.diff(twice(t), 2, axis=0) / self.interval**2
        return self._passed(seen)

    def _passed(self, values: np.ndarray) -> np.ndarray:
        return np.asarray(sosfiltfilt(self.filter, values, axis=0))

    def _used(self, lag: float) -> Iterator[tuple[Stretch, np.ndarray]]:
        """The stretches within the readings, and which of their frames are compared."""
        for one in self.whole:
            inside = (one.t > self.t[0] + MOST) & (one.t < self.t[-1] - MOST)
            a, b = np.flatnonzero(inside)[[0, -1]]
            kept = Stretch(one.t[a : b + 1], one.attitude[a : b + 1],
                           None if one.place is None else one.place[a : b + 1])  # fmt: skip
            rows = (kept.t > kept.t[0] + EDGE) & (kept.t < kept.t[-1] - EDGE)
            rows &= (kept.t >= self.low) & (kept.t < self.high)
            if rows.any():
                yield kept, rows


def _cross(v: np.ndarray) -> np.ndarray:
    x, y, z = v.T
    o = np.zeros(len(v))
    return np.stack([o, -z, y, z, o, -x, -y, x, o], axis=1).reshape(-1, 3, 3)


def by_poses(recording: Recording) -> dict[str, Measured]:
    """Delay, turn, lever arm and lean of a recording.

    u: of the parts' scatter in the middle band, and of the bands'.
    """
    pose = recording.reference
    assert pose is not None
    edges = SLOW if np.median(np.diff(pose.t)) > FAST_FRAMES else FAST
    whole = [_flat(on_body(recording, edge)) for edge in edges]
    spans = pairwise(np.linspace(0.0, 1.0, PARTS + 1).tolist())
    middle = edges[len(edges) // 2]
    parts = [_flat(on_body(recording, middle, span)) for span in spans]
    found = {}
    for name, (value, unit) in whole[len(edges) // 2].items():
        scatter = np.std([each[name][0] for each in parts], ddof=1) / np.sqrt(PARTS)
        bands = np.std([each[name][0] for each in whole], ddof=1)
        found[name] = Measured(value, float(np.hypot(scatter, bands)), unit)
    if np.isfinite(found["r_x"].value):  # gyros and accelerometers need not be equally late
        late, other = found["seconds"], _delay_of_forces(recording, middle, found["seconds"].value)
        half = 0.5 * (other - late.value)
        found["seconds"] = Measured(late.value + half, float(np.hypot(late.u, half)), "s")
    return found


def _delay_of_forces(recording: Recording, edge: float, about: float) -> float:
    """The delay, s, by which the accelerometers alone are late, near that of the gyros."""
    fit = _Fit(recording, spans_of(recording), edge, -np.inf, np.inf)
    _, matrix, bias = fit.rates(about)
    steps = NEAR * np.array([-1.0, 0.0, 1.0])
    left = [fit.forces(about + step, matrix, bias)[2] ** 2 for step in steps]
    bend, slope, _ = np.polyfit(steps, left, 2)
    return about - 0.5 * float(slope / bend) if bend > 0.0 else about


def _flat(one: OnBody) -> dict[str, tuple[float, str]]:
    return {
        "seconds": (one.delay, "s"),
        **{f"turn_{a}": (float(v), "deg") for a, v in zip("xyz", one.turn, strict=True)},
        **{name: (float(v), "m") for name, v in zip(NAMES, one.lever, strict=True)},
        **{f"lean_{a}": (float(v), "deg") for a, v in zip("xy", one.lean, strict=True)},
        "rate_left": (one.left[0], "rad/s"), "force_left": (one.left[1], "m/s2"),
    }  # fmt: skip
