"""Units at rest, up and down: Earth's rotation, and lines in the spectrum."""

import numpy as np

from tests.proof.real.fact import (
    Answer,
    Fact,
    Judged,
    Recordings,
    findings,
    in_words,
    lines_at,
    parameter,
    silent,
)
from tests.proof.real.hand.lines import amplitude, strongest
from tests.proof.real.hand.rests import half_difference, readings, rests, vertical_earth_rate
from tests.proof.text import bilingual

RING_LASER, MEMS = "ln100_two_position", "adi_mems_two_position"
ALIASED_MAINS = 40.0  # Hz: 60 Hz, sampled at 100 Hz
NEAR_NYQUIST = (28.0, 31.9)  # Hz


def two_positions(recordings: Recordings) -> list[Fact]:
    """What the two stationary recordings hold."""
    return [
        _earth(recordings),
        _no_earth(recordings),
        _mains(recordings),
        _strongest_line(recordings),
    ]


def _earth(recordings: Recordings) -> Fact:
    observation = half_difference(recordings[RING_LASER], 0)
    known = vertical_earth_rate(recordings[RING_LASER])

    def declared(answer: Answer) -> Judged:
        response = findings(answer, "earth_rotation")
        value = parameter(response[0], "vertical_rate") if response else None
        if value is None:
            return silent(answer)
        right = abs(value[0] - known.value) <= 2.0 * value[1]
        return Judged(in_words(response), "right" if right else "right name, value off")

    return Fact(
        "earth",
        (RING_LASER,),
        bilingual("Earth's rotation", "地球自转"),
        (
            bilingual(
                "half of gyro x up less down; u by batches", "陀螺x朝上减朝下之半；分批估计u"
            ),
            bilingual("15.041 deg/h · sin(latitude told)", "15.041 °/h × sin(所给纬度)"),
        ),
        (str(observation), str(known)),
        bilingual(
            "two positions show only the vertical part, and would show a g-sensitivity of the same "
            "size alike: the agreement with the latitude is what speaks for Earth",
            "两位置只反映垂直分量，且与同样大小的g灵敏度无法区分；判定依据是与纬度计算值一致",
        ),
        declared,
    )


def _no_earth(recordings: Recordings) -> Fact:
    recording = recordings[MEMS]
    observation, known = half_difference(recording, 0), vertical_earth_rate(recording)

    def declared(answer: Answer) -> Judged:
        response = findings(answer, "earth_rotation")
        if "failed" in answer:
            return silent(answer)
        return Judged(in_words(response), "wrong" if response else "right")

    return Fact(
        "no_earth",
        (MEMS,),
        bilingual("Earth's rotation cannot be seen", "看不到地球自转"),
        (
            bilingual(
                "half of gyro x up less down; u by batches", "陀螺x朝上减朝下之半；分批估计u"
            ),
            bilingual("15.041 deg/h · sin(latitude told)", "15.041 °/h × sin(所给纬度)"),
        ),
        (str(observation), str(known)),
        bilingual(
            "what is seen has the other sign: g-sensitivity or a bias that moved between the "
            "positions, which two positions do not separate",
            "实测差值符号相反：为g灵敏度或两位置之间的零偏变化，两位置无法区分",
        ),
        declared,
    )


def _mains(recordings: Recordings) -> Fact:
    recording = recordings[MEMS]
    observation = []
    for rest in rests(recording):
        t, values = readings(recording, rest)
        at = strongest(t, values[:, 3], 39.0, 41.0)
        observation.append(f"{at:.4f} Hz, {1e3 * amplitude(t, values[:, 3], at):.1f} mm/s²")

    def declared(answer: Answer) -> Judged:
        response = findings(answer, "mains_pickup")
        return Judged(in_words(response), "right") if response else silent(answer)

    return Fact(
        "mains",
        (MEMS,),
        bilingual(
            "a line at 40 Hz in the accelerometers: mains of 60 Hz, folded at 100 Hz",
            "加速度计40 Hz谱线：60 Hz工频在100 Hz采样下混叠",
        ),
        (
            bilingual("spectrum of accelerometer x, x up", "加速度计x频谱（x朝上）"),
            bilingual("the same with x down, a minute later", "一分钟后x朝下，同法"),
        ),
        (observation[0], observation[1]),
        bilingual(
            "40, 60 and 140 Hz look alike at 100 Hz; that it keeps to 60 Hz within 2e-4, in a land "
            "with 60 Hz, speaks for the mains, not its way in",
            "100 Hz采样下40、60、140 Hz不可区分；与60 Hz相差小于2e-4且当地电网为60 Hz，支持工频；"
            "耦合途径未知",
        ),
        declared,
    )


def _strongest_line(recordings: Recordings) -> Fact:
    recording = recordings[RING_LASER]
    observation, places = [], []
    for rest in rests(recording):
        t, values = readings(recording, rest)
        at = strongest(t, values[:, 2], *NEAR_NYQUIST)
        places.append(at)
        size = np.degrees(amplitude(t, values[:, 2], at))
        observation.append(f"{at:.3f} Hz, {size:.4f} deg/s")

    def declared(answer: Answer) -> Judged:
        response = [each for at in places for each in lines_at(answer, at, 0.1)]
        return Judged(in_words(response), "right") if response else silent(answer)

    return Fact(
        "strongest_line",
        (RING_LASER,),
        bilingual(
            "its strongest line, in all three gyros, moves between the positions",
            "最强谱线（三轴陀螺均有），两位置间频率有移动",
        ),
        (
            bilingual("spectrum of gyro z, x up", "陀螺z频谱（x朝上）"),
            bilingual("the same with x down", "x朝下，同法"),
        ),
        (observation[0], observation[1]),
        bilingual(
            "sampled at 64 Hz, anything below 32 Hz may be folded: the source is not told",
            "64 Hz采样的32 Hz以下均可能为混叠，来源无法判断",
        ),
        declared,
    )
