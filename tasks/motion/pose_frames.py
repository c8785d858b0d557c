"""The frames of a tracked body: parts without a gap, resampled evenly."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from schemas.recording import Stream
from tasks.motion.samples import interpolated

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

POSE = ("qw", "qx", "qy", "qz")
PLACE = ("px", "py", "pz")
BRIDGED = 3.5  # intervals between two frames that a straight line may join
BATCHED = 0.5  # of the mean step between stamps: where most are closer, frames come in batches
FEWEST = 16  # frames without a gap whose motion is known


@dataclass(frozen=True)
class Stretch:
    """Frames without a gap, at even times t (n,) s.

    attitude: of the frames as they are. turned: (n, 3) rad, its small turns added up. place: m.
    """

    t: np.ndarray
    attitude: "Rotation"
    turned: np.ndarray
    place: np.ndarray


@dataclass(frozen=True)
class Frames:
    """Stretches of frames, the time between two of them, s, and whether they have positions."""

    spans: tuple[Stretch, ...]
    interval: float
    placed: bool


def frames_of(pose: Stream) -> Frames:
    """The frames of a stream of poses, put on an even grid."""
    pose = replace(pose, t=_even_stamps(pose.t))
    interval = float(np.median(np.diff(pose.t))) if len(pose.t) > 1 else 1.0
    placed = set(PLACE) <= set(pose.columns)
    return Frames(tuple(_spans(pose, interval)), interval, placed)


def _even_stamps(t: np.ndarray) -> np.ndarray:
    """When frames stamped t (n,) s were taken, where a host stamps them in batches.

    Most stamps are then closer together than frames come, and each batch ends in a long step; the
    mean over as many as a batch has is free of it.
    """
    steps = np.diff(t)
    if len(steps) < FEWEST or np.median(steps) > BATCHED * steps.mean():
        return t
    from scipy.ndimage import correlate1d  # late: few recordings have poses

    batch = max(2, round(len(steps) / max(1, int((steps > steps.mean()).sum()))))
    kernel = np.convolve(np.ones(batch), np.ones(batch)) / batch**2
    rows = np.arange(len(t))
    slope = (t[-1] - t[0]) / rows[-1]
    return slope * rows + np.asarray(correlate1d(t - slope * rows, kernel, mode="nearest"))


def _spans(pose: Stream, interval: float) -> Iterator[Stretch]:
    from scipy.spatial.transform import Rotation  # late: few recordings have a pose

    gaps = np.flatnonzero(np.diff(pose.t) > BRIDGED * interval) + 1
    for first, end in pairwise([0, *gaps.tolist(), len(pose.t)]):
        if end - first < FEWEST:
            continue
        part = pose.at(slice(first, end))
        # Stamps are rounded: the last of an even grid can lie a hair behind the last frame.
        t = np.minimum(np.arange(part.t[0], part.t[-1], interval), part.t[-1])
        measured = Rotation.from_quat(part.stack(POSE), scalar_first=True)
        attitude = attitudes_at(t, part.t, measured)
        place = splined(t, part.t, part.stack(PLACE))
        yield Stretch(t, attitude, added_turns(attitude), place)


def attitudes_at(at: np.ndarray, t: np.ndarray, attitude: "Rotation") -> "Rotation":
    """Attitudes at times `at` (m,) s between those at t (n,) s, along a cubic spline of the turns.

    A turn at a constant rate from one to the next would take dt²ω²/12 from what swings at ω.
    """
    from scipy.spatial.transform import Rotation, Slerp

    turned = added_turns(attitude)
    bent = splined(at, t, turned) - interpolated(at, t, turned)
    return Slerp(t, attitude)(at) * Rotation.from_rotvec(bent)


def splined(at: np.ndarray, t: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(m, k) at times `at` (m,) s, by a cubic spline through values (n, k) at times t (n,) s.

    Unknown where one of the values is, as positions are that were not recorded.
    """
    from scipy.interpolate import CubicSpline

    if not np.isfinite(values).all():
        return np.full((len(at), values.shape[1]), np.nan)
    return np.asarray(CubicSpline(t, values)(at))


def added_turns(attitude: "Rotation") -> np.ndarray:
    """(n, 3) rad, the small turns from attitude to attitude added up."""
    turns = (attitude[:-1].inv() * attitude[1:]).as_rotvec()
    return np.concatenate([np.zeros((1, 3)), np.cumsum(turns, axis=0)])
