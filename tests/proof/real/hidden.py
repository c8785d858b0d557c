"""What is hidden in which real recording, and what cannot be hidden there, and why."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from schemas.recording import Recording
from schemas.text import Statement as Text
from storage.formats.folder import read_folder
from tests.proof.real.facts import SHAFT, Answer, findings, parameter, total_delay
from tests.proof.real.hand.measured import Measured
from tests.proof.real.hand.shaft import delay_by_phase, scale_by_gravity, slip_at
from tests.proof.real.hide import TRANSFORMATIONS, Size, drawn_sizes, first_part
from tests.proof.study import bilingual

PART = 60.0  # s of the shaft, to be quick: seven strokes to and fro
VISIBLE_ON_SHAFT = ("time_offset", "table_scale", "dropped_samples")


@dataclass(frozen=True)
class Hidden:
    """A known transformation in a real recording. why: it cannot be seen, if it cannot."""

    recording: str
    name: str
    size: Size
    why: Text | None = None

    def made(self, folder: Path) -> Recording:
        """The recording with it, read from the folder of the real ones."""
        return TRANSFORMATIONS[self.name](untouched(folder, self.recording), self.size)


TILT_ABSORBED: Text = bilingual(
    "one axis: a lean along it is a bias, one across it a turn of the unit, and the standard's "
    "parameters take both whole",
    "单轴：沿轴倾斜等同零偏，垂直于轴倾斜等同产品转角，均被标准参数完全吸收",
)
LABELS_ONLY: Text = bilingual(
    "labels tell means of rests and turns only: stamps that are late or slip change none of them",
    "标签仅给出静止与转动的均值：时标偏移或滑移不改变这些均值",
)
SCALE_ABSORBED: Text = bilingual(
    "no gravity beside a turn of known angle: the gyro's scale factor takes it whole",
    "已知转角之外无重力参照：被陀螺标度因数完全吸收",
)
# What is not even tried: recording, transformations, why.
NOT_HIDDEN: tuple[tuple[str, str, Text], ...] = (
    (
        "vn200_imu0_rate_table, vn200_imu1_rate_table",
        "time_offset, dropped_samples",
        bilingual(
            "steady turns were cut out by their author, ramps and times are gone",
            "作者只保留匀速段，加减速段与时间信息已缺失",
        ),
    ),
    (
        "vn200_imu0_rate_table, vn200_imu1_rate_table",
        "table_scale",
        bilingual(
            "rates are nominal and no accelerometer was kept while turning: " + SCALE_ABSORBED.en,
            "仅有名义速率且转动时未保留加速度计：" + SCALE_ABSORBED.zh,
        ),
    ),
    (
        "every recording without table angles",
        "axis_tilt",
        bilingual(
            "a label says which axis points up, not where the base leans beside it",
            "标签只说明哪一轴朝上，不说明基座倾向何方",
        ),
    ),
    (
        "xsens_multiposition",
        "all",
        bilingual("it tells no motion: explain refuses it", "未给出运动信息：解释程序拒绝处理"),
    ),
)


def untouched(folder: Path, name: str) -> Recording:
    """A real recording as it is hidden in: of the shaft the first part."""
    recording = read_folder(folder / name)
    return first_part(recording, PART) if name == SHAFT else recording


def hidden_cases(seed: int) -> list[Hidden]:
    """Everything that is hidden, sizes drawn from the seed."""
    cases = [
        Hidden(SHAFT, name, size)
        for name in VISIBLE_ON_SHAFT
        for size in drawn_sizes(seed, name, PART)
    ]
    cases += [
        Hidden(SHAFT, "axis_tilt", size, TILT_ABSORBED)
        for size in drawn_sizes(seed, "axis_tilt", PART)
    ]
    for recording, duration in (("ln100_two_position", 300.0), ("ferraris_session", 101.0)):
        most = drawn_sizes(seed, "time_offset", duration)[-1]
        cases.append(Hidden(recording, "time_offset", most, LABELS_ONLY))
    lost = drawn_sizes(seed, "dropped_samples", 300.0)[-1]
    cases.append(Hidden("ln100_two_position", "dropped_samples", lost, LABELS_ONLY))
    scale = drawn_sizes(seed, "table_scale", 101.0)[-1]
    cases.append(Hidden("ferraris_session", "table_scale", scale, SCALE_ABSORBED))
    return cases


BY_HAND: dict[str, Callable[[Recording, Size], Measured]] = {
    "time_offset": lambda recording, size: delay_by_phase(recording),
    "table_scale": lambda recording, size: scale_by_gravity(recording),
    "dropped_samples": lambda recording, size: slip_at(recording, size.at),
}


def by_hand(case: Hidden, folder: Path) -> Measured | None:
    """What a hand analysis finds of it, beyond the untouched recording; None: nothing to see.

    Of lost samples the slip, as a number of samples at 100 Hz.
    """
    if case.why is not None:
        return None
    measure = BY_HAND[case.name]
    before = measure(untouched(folder, case.recording), case.size)
    after = measure(case.made(folder), case.size)
    unit = 100.0 if case.name == "dropped_samples" else 1.0
    u = (before.u**2 + after.u**2) ** 0.5
    return Measured(unit * (after.value - before.value), unit * u, case.size.unit)


# Scores of what was hidden: the answer beside that of the untouched recording.

NORMAL_95 = 1.959964


@dataclass(frozen=True)
class Score:
    """One hidden transformation. new: names beyond the untouched recording's, without `unnamed`.

    stated: what the answer says beyond the untouched one. by_hand: the same by hand analysis.
    """

    case: Hidden
    new: tuple[str, ...]
    named: bool
    stated: Measured | None
    by_hand: Measured | None
    seconds: float
    failed: str | None

    @property
    def visible(self) -> bool:
        """There is something hidden that can be seen."""
        return self.case.why is None and self.case.size.value != 0.0

    @property
    def wrong(self) -> tuple[str, ...]:
        """New names that are not what was hidden; where nothing can be seen, any."""
        return tuple(name for name in self.new if not self.visible or name != self.case.name)

    @property
    def inside(self) -> bool:
        """The stated change holds the hidden amount in its 95 % interval."""
        if self.stated is None:
            return False
        return abs(self.stated.value - self.case.size.value) <= NORMAL_95 * self.stated.u

    @property
    def outcome(self) -> str:
        """What became of it, the worst first."""
        if self.failed:
            return "explain failed"
        if self.wrong:
            return "a wrong name"
        if not self.visible:
            return "rightly nothing new"
        if not self.named:
            return "missed"
        return "found, value right" if self.inside else "found, value off"


def scored(case: Hidden, answer: Answer, base: Answer, by_hand: Measured | None) -> Score:
    """The score of one answer; base: that of the untouched recording."""
    names, before = _names(answer), _names(base)
    new = tuple(sorted(names - before))
    return Score(
        case,
        new,
        case.name in names,
        _stated(case, answer, base) if case.why is None else None,
        by_hand,
        float(answer["seconds"]),
        answer.get("failed"),
    )


def as_data(score: Score) -> Mapping[str, Any]:
    """A score as plain data."""
    size = score.case.size
    return {
        "recording": score.case.recording,
        "hidden": score.case.name,
        "size": size.value,
        "unit": size.unit,
        "at": size.at,
        "can_be_seen": score.case.why is None,
        "new_names": list(score.new),
        "stated": score.stated and vars(score.stated),
        "by_hand": score.by_hand and vars(score.by_hand),
        "outcome": score.outcome,
        "seconds": score.seconds,
    }


def _names(answer: Answer) -> set[str]:
    return {each["effect"] for each in answer.get("findings", ())} - {"unnamed"}


def _stated(case: Hidden, answer: Answer, base: Answer) -> Measured | None:
    after, before = _amount(case.name, answer), _amount(case.name, base)
    if after is None:
        return None
    value, u = before or (0.0, 0.0)
    return Measured(after[0] - value, (after[1] ** 2 + u**2) ** 0.5, case.size.unit)


def _amount(name: str, answer: Answer) -> tuple[float, float] | None:
    """How much of an effect an answer states, and its u: all delays, all lost samples together."""
    if name == "time_offset":
        return total_delay(answer)
    response = findings(answer, name)
    if not response:
        return None
    if name == "table_scale":
        return parameter(response[0], "scale")
    lost = [p for p in response[0]["parameters"] if p["name"].startswith("lost_")]
    return sum(p["value"] for p in lost), sum(p["u"] ** 2 for p in lost) ** 0.5
