"""Steady turns that the gyros alone show, for recordings that nobody labelled."""

import numpy as np

from schemas.recording import AXES, GYRO, Recording, Segment
from tasks.motion.samples import in_blocks

BLOCK = 0.2  # s of a mean
SHORTEST = 1.5  # s
SLOWEST = np.radians(3.0)  # rad/s from rest
STEADY = 0.01  # of the rate, by which neighbouring means of a held rate differ at the most
ALIGNED = np.cos(np.radians(10.0))  # about one axis of the unit
MARGIN = 0.3  # s left off at both ends
NOMINAL = 0.03  # of a rate, by which the gyro may read another than was set


def steady_turns(recording: Recording, rests: tuple[Segment, ...]) -> tuple[Segment, ...]:
    """Turns at a held rate about one axis, in the order of time.

    The rate is the roundest number near to what the gyro reads: a proposal, for the gyro is
    not its own reference. rests: where it rests.
    """
    imu = recording.imu
    rows = max(1, round(BLOCK / max(float(np.median(np.diff(imu.t))), 1e-9)))
    means = in_blocks(np.column_stack([imu.t, imu.stack(GYRO)]), rows).mean(axis=1)
    t, rate = means[:, 0], means[:, 1:]
    at_rest = np.zeros(len(t), bool)
    for rest in rests:
        at_rest |= (t >= rest.t_start) & (t < rest.t_end)
    if not at_rest.any() or not np.isfinite(rate).all():
        return ()
    rate = rate - np.median(rate[at_rest], axis=0)
    speed = np.linalg.norm(rate, axis=1)
    change = np.linalg.norm(np.diff(rate, axis=0), axis=1)
    held = (speed[1:] > SLOWEST) & (change < STEADY * speed[1:] + 0.1 * SLOWEST)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], held.astype(int), [0]])))
    turns: list[Segment] = []
    for first, last in edges.reshape(-1, 2):
        start, end = float(t[first]) + MARGIN, float(t[last]) - MARGIN
        mean = rate[first : last + 1].mean(axis=0)
        axis = int(np.abs(mean).argmax())
        if end - start < SHORTEST or abs(mean[axis]) < ALIGNED * np.linalg.norm(mean):
            continue
        read = float(np.degrees(mean[axis]))
        rounded = (float(f"{read:.1g}"), float(f"{read:.2g}"), round(read, 3))
        nominal = next(one for one in rounded if abs(read - one) < NOMINAL * abs(read))
        name = f"turn_{len(turns) + 1:03d}"
        turns.append(Segment(name=name, kind="rate", axis=AXES[axis], rate_deg_s=nominal,
                             t_start=start, t_end=end))  # fmt: skip
    return tuple(turns)
