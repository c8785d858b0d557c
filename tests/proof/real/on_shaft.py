"""The MPU-6050 on a stepper's shaft with an optical encoder."""

import numpy as np

from schemas.recording import ACCEL
from tests.proof.real.fact import (
    Answer,
    Fact,
    Judged,
    Recordings,
    findings,
    in_words,
    parameter,
    silent,
)
from tests.proof.real.hand.measured import Measured
from tests.proof.real.hand.rounding import dead_zone_misfit, step_of
from tests.proof.real.hand.shaft import (
    corner,
    delay_by_angle,
    delay_by_gravity,
    delay_by_pattern,
    delay_by_phase,
)
from tests.proof.text import bilingual

SHAFT = "encoder_mpu6050_pitch_slow"
DATASHEET = Measured(42.0, 4.0, "Hz")  # MPU-6050 register map, DLPF_CFG 3, of a higher order


def on_shaft(recordings: Recordings) -> list[Fact]:
    """What the encoder rig holds."""
    return [
        _gyro_delay(recordings),
        _gravity_delay(recordings),
        _low_pass(recordings),
        _rounding(recordings),
    ]


def total_delay(answer: Answer) -> tuple[float, float] | None:
    """The delay, s, and its u, that an answer states: clock shift and low-pass together."""
    stated = [
        value
        for each in findings(answer, "time_offset", "bandwidth")
        for name in ("seconds", "time_constant")
        if (value := parameter(each, name))
    ]
    if not stated:
        return None
    return sum(value for value, _ in stated), float(np.linalg.norm([u for _, u in stated]))


def _judged_delay(answer: Answer, known: Measured) -> Judged:
    stated = total_delay(answer)
    if stated is None:
        return silent(answer)
    right = Measured(*stated, "s").agrees(known)
    words = in_words(findings(answer, "time_offset", "bandwidth"))
    return Judged(words, "right" if right else "right name, value off")


def _gyro_delay(recordings: Recordings) -> Fact:
    recording = recordings[SHAFT]
    by_angle = delay_by_angle(recording)
    return Fact(
        "gyro_delay",
        (SHAFT,),
        bilingual("the gyro is late against the encoder", "陀螺相对编码器滞后"),
        (
            bilingual("phase of the cross spectrum, 1 to 13 Hz", "互谱相位（1～13 Hz）"),
            bilingual(
                "lag at which the summed gyro follows the encoder's angle best",
                "积分陀螺与编码器角度最吻合的滞后",
            ),
        ),
        (str(delay_by_phase(recording)), str(by_angle)),
        bilingual(
            "4.8 ms of it is the maker's low-pass; whether the rest lies in the encoder's reading "
            "or in the bus is not told",
            "其中4.8 ms为厂家低通滤波；其余来自编码器读数还是总线无法判断",
        ),
        lambda answer: _judged_delay(answer, by_angle),
    )


def _gravity_delay(recordings: Recordings) -> Fact:
    recording = recordings[SHAFT]
    late = delay_by_gravity(recording)
    pattern = delay_by_pattern(recording)

    def declared(answer: Answer) -> Judged:
        both = findings(answer, "accel_axis_skew", "size_effect")
        return Judged(in_words(both), "wrong") if both else silent(answer)

    return Fact(
        "gravity_delay",
        (SHAFT,),
        bilingual(
            "the accelerometers are late, too, but less than the gyro", "加速度计也滞后，但小于陀螺"
        ),
        (
            bilingual("turn of gravity's pattern with the rate", "重力方向随角速率的偏转"),
            bilingual(
                "lag at which gravity's pattern over the angle fits best, no lever arm",
                "重力随角度变化最吻合的滞后（不计杆臂）",
            ),
        ),
        (str(late), str(pattern)),
        bilingual(
            "the two ways differ by what a lever arm takes, more than their scatter; no catalogue "
            "name has one delay for each triad: a single τ must be wrong for one of them",
            "两法之差源于杆臂项，大于各自离散；目录中没有两组传感器时延不同的因素：单一τ必有一组不准",
        ),
        declared,
    )


def _low_pass(recordings: Recordings) -> Fact:
    observation = corner(recordings[SHAFT])
    known = 1e3 / (2.0 * np.pi * observation.value)

    def declared(answer: Answer) -> Judged:
        response = findings(answer, "bandwidth")
        value = parameter(response[0], "time_constant") if response else None
        if value is None:
            return silent(answer)
        at = Measured(1.0 / (2.0 * np.pi * value[0]), 2.0, "Hz")
        close = value[0] > 0 and at.agrees(observation)
        return Judged(in_words(response), "right" if close else "right name, value off")

    return Fact(
        "low_pass",
        (SHAFT,),
        bilingual(
            f"the gyro's low-pass, time constant {known:.1f} ms",
            f"陀螺低通，时间常数{known:.1f} ms",
        ),
        (
            bilingual(
                "gain at the stepper's 12.8 Hz beside the gain at 1 to 5 Hz",
                "步进电机12.8 Hz处与1～5 Hz处增益之比",
            ),
            bilingual("the maker's setting", "厂家设定值"),
        ),
        (str(observation), str(DATASHEET)),
        bilingual("its order: one frequency shows one number", "滤波阶数：单一频率只能给出一个数"),
        declared,
    )


def _rounding(recordings: Recordings) -> Fact:
    recording = recordings[SHAFT]
    steps = {name: step_of(recording.imu.columns[name]) for name in ACCEL}
    (nearest, zero) = (dead_zone_misfit(recording, towards_zero=way) for way in (False, True))

    def declared(answer: Answer) -> Judged:
        response = findings(answer, "coarse_quantisation")
        return Judged(in_words(response), "right") if response else silent(answer)

    return Fact(
        "rounding",
        (SHAFT,),
        bilingual(
            "accelerometers in steps of 0.01 g, cut off towards zero",
            "加速度计步长0.01 g，向零截断",
        ),
        (
            bilingual("every reading is a whole number of steps", "全部读数为步长的整数倍"),
            bilingual(
                "accelerometer y over the angle: misfit if rounded, and if cut off",
                "加速度计y随角度的变化：四舍五入与截断两种模型的残差",
            ),
        ),
        (
            f"{steps['accel_y']:.5f} m/s²",
            f"{1e3 * nearest:.1f} and {1e3 * zero:.1f} mm/s²",
        ),
        bilingual("where it was cut: in the logger's text or before", "截断发生在记录程序还是之前"),
        declared,
    )
