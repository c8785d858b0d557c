"""One picture for each real effect, by hand analysis, and one of what was hidden and found."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from schemas.text import Statement as Text
from tasks.rendering.chart import AFTER, BEFORE, FINDINGS, PALE, draw
from tests.proof.real.facts import FIRST, MEMS, RING_LASER, SECOND, SHAFT, Recordings
from tests.proof.real.hand.measured import amplitude
from tests.proof.real.hand.rests import (
    BATCHES,
    DEG_PER_HOUR,
    means_of,
    misfit,
    rate_runs,
    readings,
    rests,
    series,
    turns_per_second,
    vertical_earth_rate,
)
from tests.proof.real.hand.shaft import alike, delay_by_angle, lag_series, transfer
from tests.proof.real.hidden import Score
from tests.proof.real.hide import Size, shifted_clock
from tests.proof.study import bilingual

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# A small chart with two axes.


@dataclass(frozen=True)
class Series:
    """Points (n,) and (n,); bars: half lengths (n,). A line, or dots with their bars."""

    name: str
    x: np.ndarray
    y: np.ndarray
    colour: str
    dots: bool = False
    bars: np.ndarray | None = None


@dataclass(frozen=True)
class Mark:
    """An upright (across=False) or level line with its words."""

    name: str
    at: float
    colour: str
    across: bool = False


def chart(
    title: str, x_name: str, y_name: str, series: Sequence[Series], marks: Sequence[Mark] = ()
) -> str:
    """The picture, with its axes from the least to the largest of what is drawn."""

    def content(figure: "Figure") -> None:
        axes = figure.subplots()
        for line in series:
            style = "o" if line.dots else "-"
            axes.errorbar(line.x, line.y, line.bars, fmt=style, color=line.colour, markersize=7,
                          linewidth=1.8, elinewidth=1.4, label=line.name)  # fmt: skip
        for mark in marks:
            draw_line = axes.axhline if mark.across else axes.axvline
            draw_line(mark.at, color=mark.colour, linewidth=1.6, label=mark.name or None)
        axes.set_xlabel(x_name, loc="right")
        axes.set_ylabel(y_name, loc="top")
        axes.grid(axis="y", color=PALE)
        axes.set_axisbelow(True)
        axes.spines["left"].set_visible(False)
        figure.legend(loc="outside upper left", ncols=len(series) + len(marks))

    return draw(title, 760, 356, content)


LAGS = np.linspace(-0.01, 0.05, 61)  # s
SHIFT = 0.010  # s, hidden for the picture


@dataclass(frozen=True)
class Picture:
    """An SVG, what it shows, and the key of the fact that it is of; none: what was hidden."""

    svg: str
    caption: Text
    fact: str = ""


def pictures_of(recordings: Recordings, scores: Sequence[Score]) -> list[Picture]:
    """Every picture."""
    drawn = {
        "earth": _earth,
        "gyro_delay": _delay,
        "low_pass": _phase,
        "ripple": _ripple,
        "exchanged": _exchanged,
        "mains": _mains,
    }
    made = [replace(draw(recordings), fact=key) for key, draw in drawn.items()]
    return made + _hidden(scores)


def _earth(recordings: Recordings) -> Picture:
    recording = recordings[RING_LASER]
    drawn = []
    for rest, colour in zip(rests(recording), (BEFORE, AFTER), strict=True):
        t, values = readings(recording, rest)
        parts = np.array_split(np.arange(len(t)), BATCHES)
        y = np.array([values[part, 0].mean() for part in parts]) * DEG_PER_HOUR
        at = np.array([t[part].mean() for part in parts]) / 60.0
        drawn.append(Series(f"gyro x, {rest.up}", at, y, colour, dots=True))
    known = vertical_earth_rate(recording).value
    mean = np.mean([each.y.mean() for each in drawn])
    words = "mean ± Earth's rate by latitude"
    marks = [
        Mark(name, mean + side * known, FINDINGS[1], across=True)
        for name, side in ((words, 1.0), ("", -1.0))
    ]
    svg = chart("Rests by Earth's rate", "min", "deg/h", drawn, marks)
    return Picture(
        svg,
        bilingual(
            "The ring-laser unit at rest: gyro x in batches of 30 s, x up and then down, beside "
            "± Earth's vertical rate at the latitude told.",
            "激光陀螺产品静止：陀螺x每30 s均值，先朝上后朝下，与按纬度计算的地球自转垂直分量比较。",
        ),
    )


def _delay(recordings: Recordings) -> Picture:
    recording = recordings[SHAFT]
    late = shifted_clock(recording, Size(SHIFT, "s"))
    drawn = [
        Series(name, 1e3 * LAGS, 1e3 * lag_series(each, LAGS), colour)
        for name, each, colour in (
            ("as recorded", recording, AFTER),
            ("10 ms hidden", late, BEFORE),
        )
    ]
    found = delay_by_angle(recording).value
    marks = [Mark(f"{1e3 * found:.1f} ms", 1e3 * found, FINDINGS[1])]
    return Picture(
        chart("Delay of the gyro", "lag, ms", "misfit, mrad", drawn, marks),
        bilingual(
            "The encoder's angle less the summed gyro, by the lag between them: the gyro is late, "
            "and a hidden shift adds to it by its full size.",
            "编码器角度与积分陀螺之差随滞后的变化：陀螺滞后，隐藏的时移按其全量叠加。",
        ),
    )


def _phase(recordings: Recordings) -> Picture:
    frequency, gain, coherence = transfer(recordings[SHAFT])
    good = alike(gain, coherence) & (frequency > 0.5) & (frequency < 13.1)
    series = 0.01 * np.arange(0.0, 1301.0)
    phase = np.unwrap(np.angle(gain[good]))
    low_pass = -np.degrees(np.arctan(2.0 * np.pi * series * 0.00719))
    delay = -360.0 * series * delay_by_angle(recordings[SHAFT]).value
    drawn = [
        Series("a low-pass of 7.2 ms", series, low_pass, BEFORE),
        Series("a delay, by the angle", series, delay, AFTER),
        Series("measured", frequency[good], np.degrees(phase), FINDINGS[1], dots=True),
    ]
    return Picture(
        chart("Phase of the gyro", "Hz", "phase, deg", drawn),
        bilingual(
            "Phase from the encoder's rate to the gyro where they are coherent (0.98 and more): a "
            "straight line through zero is a delay.",
            "编码器速率到陀螺的相位（相干度不低于0.98）：过零直线即为纯时延。",
        ),
    )


def _ripple(recordings: Recordings) -> Picture:
    orders = np.linspace(40.0, 52.0, 601)
    drawn = []
    for name, colour in ((FIRST, AFTER), (SECOND, BEFORE)):
        segment = next(each for each in rate_runs(recordings[name]) if each.rate_deg_s == 30.0)
        t, rate = series(recordings[name], segment)
        turning = turns_per_second(segment)
        y = np.array([np.degrees(amplitude(t, rate, order * turning)) for order in orders])
        drawn.append(Series(name[6:10].upper(), orders, y, colour))
    return Picture(
        chart("Ripple of the rate table", "waves a turn", "deg/s", drawn),
        bilingual(
            "Both units on the rate table, x up, 30 deg/s: amplitude over waves a turn. What both "
            "see alike is the table's.",
            "同台两产品，30 °/s：幅值随每转波数的变化。两者一致者来自转台。",
        ),
    )


def _exchanged(recordings: Recordings) -> Picture:
    directions, mine = means_of(recordings[FIRST])
    _, theirs = means_of(recordings[SECOND])
    turned = (np.abs(directions[:, 2]) > 0)[:, None]
    as_declared = misfit(directions, mine[:, 3:])[:, 2]
    swapped = misfit(directions, np.where(turned, theirs, mine)[:, 3:])[:, 2]
    at = np.arange(1.0, 7.0)
    drawn = [
        Series("IMU0 as its files say", at - 0.05, 1e3 * as_declared, BEFORE, dots=True),
        Series("with the z rests of IMU1", at + 0.05, 1e3 * swapped, AFTER, dots=True),
    ]
    return Picture(
        chart("Rests exchanged", "rest: +x, −x, +y, −y, +z, −z", "accel z, mm/s²", drawn),
        bilingual(
            "What bias and matrix leave of accelerometer z in six rests: nothing, once the z rests "
            "of the two units are exchanged.",
            "六位置下加速度计z的残差：将两台产品z位置数据互换后残差消失。",
        ),
    )


def _mains(recordings: Recordings) -> Picture:
    recording, drawn = recordings[MEMS], []
    places = np.linspace(39.5, 40.5, 401)
    for rest, colour in zip(rests(recording), (BEFORE, AFTER), strict=True):
        t, values = readings(recording, rest)
        y = np.array([1e3 * amplitude(t, values[:, 3], at) for at in places])
        drawn.append(Series(f"x {rest.up}", places, y, colour))
    return Picture(
        chart("Mains, folded", "Hz", "accel x, mm/s²", drawn),
        bilingual(
            "The MEMS unit in two positions: the same line at 40 Hz, which is 60 Hz at 100 samples "
            "a second.",
            "MEMS产品两个位置：同一条40 Hz谱线，即100 Hz采样下的60 Hz。",
        ),
    )


def _hidden(scores: Sequence[Score]) -> list[Picture]:
    """Stated beside hidden, for each transformation that can be seen."""
    made = []
    for name, unit in (("time_offset", "s"), ("table_scale", "1"), ("dropped_samples", "1")):
        each = [one for one in scores if one.case.name == name and one.case.why is None]
        if not each:
            continue
        size = np.array([one.case.size.value for one in each])
        drawn = [Series("hidden", np.sort(size), np.sort(size), FINDINGS[1])]
        for words, colour, which in (("by hand", AFTER, "by_hand"), ("explain", BEFORE, "stated")):
            declared = [
                (x, m) for x, one in zip(size, each, strict=True) if (m := getattr(one, which))
            ]
            if declared:
                x, y, u = (
                    np.array(column)
                    for column in zip(*((x, m.value, 2.0 * m.u) for x, m in declared), strict=True)
                )
                drawn.append(Series(words, x, y, colour, dots=True, bars=u))
        made.append(
            Picture(
                chart(f"{name}, hidden and found", f"hidden, {unit}", f"found, {unit}", drawn),
                bilingual(
                    f"{name} hidden in the shaft's recording, and what was found beyond the "
                    "untouched one. Bars: 95 %. No dot: not found.",
                    f"在转轴记录中隐藏{name}后与原记录相比新发现的量；"
                    "短线为95 %区间，无点表示未发现。",
                ),
            )
        )
    return made
