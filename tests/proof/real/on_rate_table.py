"""Two VN-200 that rode the same rate table at the same time."""

import numpy as np

from tests.proof.real.fact import Answer, Fact, Judged, Recordings, findings, in_words, silent
from tests.proof.real.hand.rate_table import ripple, together, waves_per_turn
from tests.proof.real.hand.rests import means_of, misfit
from tests.proof.text import bilingual

FIRST, SECOND = "vn200_imu0_rate_table", "vn200_imu1_rate_table"
BENCH = "vn200_57630_six_position"
MOST_PER_TURN = 48.0


def on_rate_table(recordings: Recordings) -> list[Fact]:
    """What the table did to both, what became of their files, and labels that are upside down."""
    return [_ripple(recordings), _exchanged(recordings), _reversed(recordings)]


def _ripple(recordings: Recordings) -> Fact:
    one, other = recordings[FIRST], recordings[SECOND]
    depths = [
        f"{waves_per_turn(each)} a turn; {ripple(each, MOST_PER_TURN, 30.0)}"
        for each in (one, other)
    ]
    alike = together(one, other, MOST_PER_TURN)

    def declared(answer: Answer) -> Judged:
        response = findings(answer, "rate_ripple")
        if response:
            return Judged(in_words(response), "right")
        located = [
            each
            for each in findings(answer, "unnamed")
            if any(p["name"] in ("per_turn", "order", "frequency") for p in each["parameters"])
            and any(channel.startswith("gyro") for channel in each["channels"])
        ]
        return Judged(in_words(located), "right") if located else silent(answer)

    return Fact(
        "ripple",
        (FIRST, SECOND),
        bilingual(
            "the table's rate ripples 48 (and 44) times a turn", "转台速率每转波动48次（及44次）"
        ),
        (
            bilingual(
                "strongest line of the turning gyro of IMU0, x and y turns at 30 deg/s",
                "IMU0绕x、y轴30 °/s转动时的最强谱线",
            ),
            bilingual(
                f"the same in IMU1, which rode with it: coherence {alike:.3f}",
                f"同台的IMU1，同法：相干度{alike:.3f}",
            ),
        ),
        (depths[0], depths[1]),
        bilingual(
            "motor cogging, or its drive: not told; turns about z have it not, which speaks for "
            "another set-up of the drive",
            "电机齿槽还是驱动引起，无法判断；绕z转动时没有，可能驱动设置不同",
        ),
        declared,
    )


def _exchanged(recordings: Recordings) -> Fact:
    directions, mine = means_of(recordings[FIRST])
    _, theirs = means_of(recordings[SECOND])
    mine, theirs = mine[:, 3:], theirs[:, 3:]
    before = [_size(misfit(directions, each)) for each in (mine, theirs)]
    after = {}
    for axis, name in enumerate("xyz"):
        turned = np.abs(directions[:, axis]) > 0
        pair = (np.where(turned[:, None], theirs, mine), np.where(turned[:, None], mine, theirs))
        after[name] = [_size(misfit(directions, each)) for each in pair]

    def declared(answer: Answer) -> Judged:
        response = findings(answer, "unnamed", channel="accel_z")
        wrong = [
            each
            for each in answer.get("findings", ())
            if each["effect"] != "unnamed" and "accel_z" in each["channels"]
        ]
        if wrong:
            return Judged(in_words(wrong), "wrong")
        return Judged(in_words(response), "right") if response else silent(answer)

    return Fact(
        "exchanged",
        (FIRST, SECOND),
        bilingual("z rests of the two units were exchanged", "两台产品的z位置数据互换"),
        (
            bilingual(
                "misfit of the accelerometers' six rests to bias and matrix, IMU0 and IMU1",
                "六位置加速度计数据对零偏与矩阵模型的残差（IMU0、IMU1）",
            ),
            bilingual(
                "the same with the z rests exchanged; in brackets with x, with y",
                "互换z静止数据后的残差；括号内为互换x、y",
            ),
        ),
        (
            _pair(before),
            f"{_pair(after['z'])} ({_pair(after['x'])}; {_pair(after['y'])})",
        ),
        bilingual(
            "when and by whom; one recording alone cannot tell: `unnamed` is right",
            "何时何人所致不明；单一记录无法判断，故“未命名”为正确",
        ),
        declared,
    )


def _reversed(recordings: Recordings) -> Fact:
    directions, means = means_of(recordings[BENCH])
    along = (directions * means[:, 3:]).sum(axis=1)

    def declared(answer: Answer) -> Judged:
        return silent(answer)

    return Fact(
        "reversed",
        (BENCH,),
        bilingual("labels of x and y are upside down", "x、y位置标签颠倒"),
        (
            bilingual("reading along the label: x, x, y, y", "沿标签方向的读数：x、x、y、y"),
            bilingual("the same for z, z", "z、z，同法"),
        ),
        (
            ", ".join(f"{value:.2f}" for value in along[:4]) + " m/s²",
            ", ".join(f"{value:.2f}" for value in along[4:]) + " m/s²",
        ),
        bilingual(
            "whether the labels or a unit turned half round about z: the same data",
            "标签错误，还是产品绕z转了180°：数据相同",
        ),
        declared,
    )


def _size(left: np.ndarray) -> float:
    """Root mean square, mm/s², of the largest channel; two degrees of freedom."""
    return float(1e3 * np.sqrt((left**2).sum(axis=0) / 2.0).max())


def _pair(sizes: list[float]) -> str:
    return " and ".join(f"{size:.1f}" for size in sizes) + " mm/s²"
