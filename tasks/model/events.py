"""What is said of effects that are events in the readings and no term of a model.

A saturation, lost samples, coarse steps and a mains line are found by looking at the samples; the
words for them stand here, in the order of those of a `Term`.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from tasks.model.term import Text


@dataclass(frozen=True)
class EventText:
    """Name, equation, source and words of an effect; the fields mean what a `Term`'s do."""

    name: str
    family: str
    title: Text
    equation: str
    source: str
    confused_with: tuple[str, ...]
    separated_by: Text


_EVENTS = (
    EventText(
        "gyro_saturation", "gyro", ("gyro output stops at a limit", "陀螺输出饱和"),
        "ω′ᵢ = max(−L, min(L, ω′ᵢ))", "IEEE Std 528; IEEE Std 1431",
        ("gyro_scale_nonlinearity",),
        (
            "rates in small steps up to and beyond the limit, in both directions",
            "正反两个方向以小步距加至并超过极限的速率点",
        ),
    ),
    EventText(
        "accel_saturation", "accelerometer",
        ("accelerometer output stops at a limit", "加速度计输出饱和"),
        "a′ᵢ = max(−L, min(L, a′ᵢ))", "IEEE Std 528; IEEE Std 1293",
        ("accel_nonlinearity",),
        (
            "a tumble in steps of 10 deg or finer about the vertical position of the axis, or a "
            "centrifuge beyond the limit",
            "步距不大于10°的重力场翻滚试验，或超过极限的离心机试验",
        ),
    ),
    EventText(
        "dropped_samples", "time", ("samples lost, later time stamps slip", "丢帧（采样丢失）"),
        "y′ₖ = y(tₖ + n·Δt) after n lost samples", "definition of a time stamp; IEEE Std 1554",
        ("clock_skew", "time_offset"),
        (
            "a run with a counter in each frame, or with a trigger recorded by both clocks",
            "数据帧带计数器，或由两套时钟同时记录触发信号后重测",
        ),
    ),
    EventText(
        "coarse_quantisation", "electronics",
        ("step of the output visible above the noise", "量化步长过大（分辨率不足）"),
        "y′ᵢ = q·round(yᵢ/q), white noise q²/12 where the noise is large", "IEEE Std 1241",
        ("bias_random_walk",),
        (
            "a slow turn through small inputs: the output stays on levels that are a step apart",
            "缓慢改变小输入量：输出只停留在相差一个步长的若干台阶上",
        ),
    ),
    EventText(
        "mains_pickup", "electronics",
        ("line at mains frequency or its alias", "工频干扰（或其混叠）"),
        "bᵢ(t) = Aᵢ·cos(2πf·t + φᵢ), f = |n·fs − 50 Hz| or |n·fs − 60 Hz|", "IEEE Std 952",
        ("rate_ripple",),
        (
            "a rest on battery, and one at another sample rate: an alias moves, a resonance stays",
            "电池供电静止测试一次，并改变采样率再测一次：混叠谱线随之移动，机械谐振不动",
        ),
    ),
)  # fmt: skip

EVENT_TEXTS: Mapping[str, EventText] = {event.name: event for event in _EVENTS}
