"""Noise of each channel over the longest rests: random walk and bias instability.

Source: IEEE Std 952, annex C: the random walk coefficient N is the Allan deviation of the white
part at 1 s; the bias instability is the minimum of the Allan deviation over √(2·ln 2/π) = 0.664.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from schemas.calibration import Information
from schemas.recording import ACCEL, AXES, GYRO, Recording
from tasks.segments.summarise import SegmentMean, coarsely_quantised
from tasks.specifications.evidence import Evidence
from tasks.specifications.information.allan import (
    FEWEST_LEVELS,
    AllanCurve,
    WhiteNoise,
    allan_curve,
    white_noise,
)
from tasks.specifications.information.shown import shown
from tasks.specifications.parts import DEG

FLOOR = float(np.sqrt(2.0 * np.log(2.0) / np.pi))  # 0.664
AS_LONG = 0.9  # of the longest rest: rests as long as it is
GAP = 1.5  # sampling intervals: a longer step is a lost row
FALLING = 2.5  # times the minimum at a quarter of its averaging time: white noise makes half of it
SQRT_HOUR = 60.0  # √(3600 s)
HOUR = 3600.0


@dataclass(frozen=True)
class Triad:
    """How the noise of a triad is named and printed; `walk`, `floor`: SI into printed units."""

    key: str
    columns: tuple[str, ...]
    first: int
    walk_name: tuple[str, str]
    walk_key: str
    walk_unit: str
    walk: float
    floor_name: tuple[str, str]
    floor_unit: str
    floor: float


GYROS = Triad(
    "gyro", GYRO, 0,
    ("Angle random walk of the gyros", "陀螺角度随机游走系数"),
    "gyro_angle_random_walk", "deg/sqrt(h)", DEG * SQRT_HOUR,
    ("Bias instability of the gyros", "陀螺零偏不稳定性"), "deg/h", DEG * HOUR,
)  # fmt: skip
ACCELEROMETERS = Triad(
    "accel", ACCEL, 3,
    ("Velocity random walk of the accelerometers", "加速度计速度随机游走系数"),
    "accel_velocity_random_walk", "(m/s2)/sqrt(Hz)", 1.0,
    ("Bias instability of the accelerometers", "加速度计偏值不稳定性"), "m/s2", 1.0,
)  # fmt: skip
AHRS = Triad(
    "ahrs", GYRO, 0,
    ("Angle random walk of the axes", "各轴角度随机游走系数"),
    "ahrs_angle_random_walk", "deg/sqrt(h)", DEG * SQRT_HOUR,
    ("Bias instability of the axes", "各轴零偏不稳定性"), "deg/h", DEG * HOUR,
)  # fmt: skip


def noise_information(
    recording: Recording, evidence: Evidence, *, ahrs: bool
) -> dict[str, Information]:
    """Random walk and bias instability of each triad that the recording has."""
    made: dict[str, Information] = {}
    for triad in (AHRS,) if ahrs else (GYROS, ACCELEROMETERS):
        if all(name in recording.imu.columns for name in triad.columns):
            made |= _of_triad(recording, evidence, triad)
    return made


def _of_triad(recording: Recording, evidence: Evidence, triad: Triad) -> dict[str, Information]:
    rests = _longest(recording, evidence, triad)
    if not rests:
        return {}
    seconds = min(rest.seconds for rest in rests)
    interval = float(np.median([rest.seconds / rest.rows for rest in rests]))
    within = (recording.imu.rows(rest.segment.t_start, rest.segment.t_end) for rest in rests)
    readings = [recording.imu.channels(triad.columns, rows) for rows in within]
    curve = allan_curve(readings, interval)
    coarse = np.any([coarsely_quantised(rest) for rest in rests], axis=0)
    fine = [i for i in range(3) if not coarse[triad.first + i]]
    white = {i: white_noise(curve, i) for i in fine if len(curve.tau) >= FEWEST_LEVELS}
    source = (
        f"{len(rests)} {'rest' if len(rests) == 1 else 'rests'} of {seconds:.0f} s",
        f"{len(rests)} 段 {seconds:.0f} s 静止数据",
    )
    hidden = [AXES[i] for i in range(3) if i not in fine]
    return {
        triad.walk_key: _walk(triad, white, source, hidden),
        f"{triad.key}_bias_instability": _floor(triad, curve, white.keys(), source, hidden),
    }


def _longest(recording: Recording, evidence: Evidence, triad: Triad) -> list[SegmentMean]:
    """The rests as long as the longest, whole: no row left out of them and none lost."""
    whole = [
        s
        for s in evidence.segments
        if s.segment.kind == "static"
        and s.left_out == 0
        and np.isfinite(s.mean[triad.first : triad.first + 3]).all()
        and _without_gap(recording, s)
    ]
    longest = max((s.seconds for s in whole), default=0.0)
    return [s for s in whole if s.seconds >= AS_LONG * longest]


def _without_gap(recording: Recording, rest: SegmentMean) -> bool:
    t = recording.imu.t[recording.imu.rows(rest.segment.t_start, rest.segment.t_end)]
    return bool(np.diff(t).max(initial=0.0) < GAP * rest.seconds / rest.rows)


def _walk(
    triad: Triad,
    white: Mapping[int, WhiteNoise | None],
    source: tuple[str, str],
    hidden: Sequence[str],
) -> Information:
    value, u = np.full(3, np.nan), np.full(3, np.nan)
    for i, found in white.items():
        if found is not None:
            value[i] = np.sqrt(found.density)
            u[i] = found.u / (2.0 * value[i])
    why = _hidden(hidden)
    absent = [AXES[i] for i in range(3) if np.isnan(value[i]) and AXES[i] not in hidden]
    if absent:
        listed = ", ".join(absent)
        why.append((f"{listed}: white noise does not show.", f"{listed}：未见白噪声。"))
    return shown(
        triad.walk_name, triad.walk_unit, triad.walk * value, triad.walk * u,
        (
            f"White noise from the overlapping Allan deviation of {source[0]} (IEEE Std 952).",
            f"由{source[1]}的重叠 Allan 方差中的白噪声项求得（IEEE Std 952）。",
        ),
        *why,
    )  # fmt: skip


def _floor(
    triad: Triad,
    curve: AllanCurve,
    measured: Collection[int],
    source: tuple[str, str],
    hidden: Sequence[str],
) -> Information:
    value, u, at = np.full(3, np.nan), np.full(3, np.nan), np.full(3, np.nan)
    for i in measured:
        level = int(curve.variance[:, i].argmin())
        least = float(curve.variance[level, i])
        if level >= 2 and curve.variance[level - 2, i] < FALLING * least:
            at[i], value[i] = curve.tau[level], np.sqrt(least) / FLOOR
            u[i] = value[i] / np.sqrt(2.0 * curve.flicker_dof[level])
    said = _hidden(hidden)
    reached = [f"{AXES[i]} {at[i]:.3g} s" for i in range(3) if np.isfinite(at[i])]
    if reached:
        listed = ", ".join(reached)
        said.insert(0, (f"Averaging times: {listed}.", f"平均时间：{listed}。"))
    falling = [AXES[i] for i in range(3) if np.isnan(at[i]) and AXES[i] not in hidden]
    if falling:
        listed = ", ".join(falling)
        said.append((
            f"{listed}: no floor up to an averaging time of {curve.tau.max(initial=0.0):.3g} s; "
            "longer rests would show it.",
            f"{listed}：平均时间至 {curve.tau.max(initial=0.0):.3g} s 未见最小值，"
            "需更长的静止时间。",
        ))  # fmt: skip
    return shown(
        triad.floor_name, triad.floor_unit, triad.floor * value, triad.floor * u,
        (
            f"Minimum of the Allan deviation of {source[0]}, over 0.664.",
            f"由{source[1]}的 Allan 标准差最小值除以 0.664 求得。",
        ),
        *said,
    )  # fmt: skip


def _hidden(axes: Sequence[str]) -> list[tuple[str, str]]:
    """Why channels whose step hides their noise have no value."""
    if not axes:
        return []
    listed = ", ".join(axes)
    return [(f"{listed}: the output's step hides the noise.", f"{listed}：输出分辨力掩盖了噪声。")]
