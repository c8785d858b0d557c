"""Numbers in offset binary: half of the codes' range was never taken off them.

No sensor reads half of its range at rest; what is read beside that is right, and the half is a
power of two of codes. Gravity, of which the repair knows nothing, shows that of accelerometers.
"""

from dataclasses import replace

import numpy as np

from schemas.recording import TRIADS, Recording
from tasks.motion.whole import gravity_of
from tasks.readings.lattice import quantiser_of
from tasks.readings.robust import median
from tasks.words import message, remark

SAMPLE = 20_000  # rows that are looked at
BITS = range(8, 24)
NEAR_HALF = 0.05  # of the half, by which a gyro's usual reading may be off it
LIKE_GRAVITY = 0.15  # of gravity, by which accelerometers may read it wrongly
CODE = "offset_binary"


def offset_taken_off(recording: Recording) -> Recording:
    """The recording with half of the range taken off triads that are in offset binary, which it
    says; itself where none is."""
    imu, put_right = recording.imu, recording.put_right
    if any(one.code == CODE for one in put_right) or not len(imu):
        return recording
    columns = dict(imu.columns)
    for triad in TRIADS:
        if not set(triad) <= set(columns):
            continue
        every = len(imu) // SAMPLE + 1
        sample = np.array([each[::every] for each in imu.views(triad, slice(0, len(imu)))])
        sample = sample[:, np.isfinite(sample).all(axis=0)]
        if not sample.shape[1] or sample.min() <= 0.0:
            continue
        found = _half(sample, gravity_of(recording) if triad[0].startswith("accel") else None)
        if found is None:
            continue
        bits, half = found
        columns |= {c: columns[c] - one for c, one in zip(triad, half, strict=True)}
        sentence = message("plausibility-offset-binary", sensors=triad[0][:-2], codes=1 << bits,
                           read=f"{float(half.mean()):.6g}")  # fmt: skip
        put_right = (*put_right, remark(CODE, sentence, blocks_pass=True, run="remarks"))
    if put_right is recording.put_right:
        return recording
    return replace(recording, imu=replace(imu, columns=columns), put_right=put_right)


def _half(sample: np.ndarray, gravity: float | None) -> tuple[int, np.ndarray] | None:
    """The bit that is half of the range of a triad (3, n) whose readings are all above zero, and
    that half (3,) in its unit; None where none is.
    """
    lattices = [quantiser_of(channel) for channel in sample]
    steps = np.array([lattice.step for lattice in lattices if lattice is not None])
    if not len(steps):
        return None
    step, usual = np.full(3, steps.min()), median(sample)
    for bit in BITS:
        half = step * (1 << bit)
        if (sample > 2.0 * half[:, None]).any():
            continue
        if gravity is None:
            is_half = bool((np.abs(usual / half - 1.0) < NEAR_HALF).all())
        else:
            sizes = [np.median(np.linalg.norm(each, axis=0)) for each in
                     (sample, sample - half[:, None])]  # fmt: skip
            off = np.abs(np.array(sizes) / gravity - 1.0)
            is_half = bool(off[0] > LIKE_GRAVITY > off[1])
        if is_half:
            return bit, half
    return None
