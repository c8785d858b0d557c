"""What was noticed during a run, and the remarks it becomes."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby

from schemas.calibration import Remark
from schemas.procedure import EnvironmentLimits
from schemas.recording import Segment

MEASURED = ("static", "rate", "rotation")
NAMED = 3


@dataclass(frozen=True)
class Finding:
    """Something noticed between two times (s): `amount` counts it or is the value seen."""

    code: str
    t_start: float
    t_end: float
    amount: float = 1.0
    subject: str = ""


@dataclass(frozen=True)
class Wording:
    """Sentences with the fields subject, total, low, high and limits, in front of the place."""

    en: str
    zh: str
    blocks_pass: bool = False


WORDINGS = {
    "unit_lost_samples": Wording(
        "The unit's counter shows {total:.0f} lost samples",
        "被校单元的帧计数表明丢失 {total:.0f} 个采样",
    ),
    "unit_bad_frames": Wording(
        "{total:.0f} frames of the unit had a wrong check sum and were left out",
        "被校单元有 {total:.0f} 帧校验错误，已舍弃",
    ),
    "encoder_gap": Wording(
        "{total:.0f} captured encoder samples are missing",
        "缺少 {total:.0f} 个转台编码器采样",
    ),
    "air_temperature": Wording(
        "The air was at {low:.1f} to {high:.1f} °C where the procedure allows {limits} °C",
        "环境温度为 {low:.1f}～{high:.1f} ℃，超出规程允许的 {limits} ℃",
        blocks_pass=True,
    ),
    "air_humidity": Wording(
        "The air was at {low:.0f} to {high:.0f} %RH where the procedure allows {limits} %RH",
        "相对湿度为 {low:.0f}～{high:.0f} %RH，超出规程允许的 {limits} %RH",
        blocks_pass=True,
    ),
    "table_unsettled": Wording(
        "Axis {subject} of the table was not settled while data were taken",
        "采集数据期间转台 {subject} 轴未稳定",
    ),
    "table_rate": Wording(
        "The encoders show axis {subject} turning {low:+.3f} % to {high:+.3f} % off the rate asked",
        "编码器表明转台 {subject} 轴的角速率与给定值相差 {low:+.3f} %～{high:+.3f} %",
    ),
    "stuck_channel": Wording(
        "Channel {subject} of the unit did not change by one count",
        "被校单元的 {subject} 输出始终不变",
    ),
    "spikes": Wording(
        "Channel {subject} of the unit has {total:.0f} spikes",
        "被校单元的 {subject} 输出有 {total:.0f} 个野值",
    ),
}


def remarks_on(
    findings: Iterable[Finding], segments: Sequence[Segment], limits: EnvironmentLimits
) -> tuple[Remark, ...]:
    """One remark for each thing noticed, with the measured segments that it touches.

    A condition of the specification that was broken only between measured segments does not
    stop a unit from passing.
    """
    ordered = sorted(findings, key=lambda finding: (finding.code, finding.subject))
    groups = groupby(ordered, key=lambda finding: (finding.code, finding.subject))
    return tuple(_remark(tuple(group), segments, limits) for _, group in groups)


def _remark(
    findings: tuple[Finding, ...], segments: Sequence[Segment], limits: EnvironmentLimits
) -> Remark:
    code = findings[0].code
    touched = tuple(
        segment.name
        for segment in segments
        if segment.kind in MEASURED
        and any(f.t_start < segment.t_end and f.t_end >= segment.t_start for f in findings)
    )
    amounts = [finding.amount for finding in findings]
    fields = {
        "subject": findings[0].subject,
        "total": sum(amounts),
        "low": min(amounts),
        "high": max(amounts),
        "limits": _limits(code, limits),
    }
    wording = WORDINGS[code]
    return Remark(
        code=code,
        en=f"{wording.en.format(**fields)} ({_place_en(touched)}).",
        zh=f"{wording.zh.format(**fields)}（{_place_zh(touched)}）。",
        segments=touched,
        blocks_pass=wording.blocks_pass and bool(touched),
    )


def _limits(code: str, limits: EnvironmentLimits) -> str:
    low, high = limits.humidity_percent if code == "air_humidity" else limits.temperature_degc
    return f"{low:g}–{high:g}"


def _place_en(touched: tuple[str, ...]) -> str:
    if not touched:
        return "between the measured segments"
    more = f" and {len(touched) - NAMED} more segments" if len(touched) > NAMED else ""
    return f"in {', '.join(touched[:NAMED])}{more}"


def _place_zh(touched: tuple[str, ...]) -> str:
    if not touched:
        return "不在测量段内"
    more = f"等 {len(touched)} 段" if len(touched) > NAMED else ""
    return f"{'、'.join(touched[:NAMED])}{more}"
