"""Claims of explain on real recordings that look doubtful, tried by hand."""

import numpy as np

from tests.proof.real.fact import Claim, Recordings, Truth, findings, lines_at, parameter
from tests.proof.real.hand.lines import prominence
from tests.proof.real.hand.rests import CHANNELS, means_of, readings, rests, wander
from tests.proof.real.hand.rounding import dead_zone_misfit
from tests.proof.real.hand.shaft import excursion, jump_at, line_shared
from tests.proof.real.on_rate_table import BENCH, SECOND
from tests.proof.real.on_shaft import SHAFT
from tests.proof.real.two_positions import MEMS, RING_LASER
from tests.proof.text import bilingual

BY_HAND = "ferraris_session"
VISIBLE = 3.3  # amplitude over its surroundings that noise shows once in 2000 places
FAINT = 2.0  # and once in 16
MOVED = 1.0  # m/s²: a unit that is being handled


def claims_of(recordings: Recordings) -> list[Claim]:
    """Every doubtful claim with its trial."""
    return [
        _line(recordings, RING_LASER, 9.184, (1,), parts=3),
        _line(recordings, MEMS, 36.702, (3, 5)),
        _line(recordings, MEMS, 35.754, (3, 5)),
        _line(recordings, BENCH, 14.158, (1,)),
        _line(recordings, BENCH, 3.619, (0,)),
        _walk(recordings, BENCH, (3, 4, 5), "accelerometers", "加速度计"),
        _walk(recordings, BENCH, (0, 2), "gyros x and z", "陀螺x、z"),
        _as_many_as_rests(recordings),
        _walk(recordings, BY_HAND, (3, 4, 5), "accelerometers", "加速度计"),
        _walk(recordings, BY_HAND, (0, 1, 2), "gyros", "陀螺"),
        _bursts(recordings),
        _products(recordings),
        _stepper(recordings),
        _jump(recordings),
    ]


def _line(
    recordings: Recordings, name: str, at: float, channels: tuple[int, ...], parts: int = 1
) -> Claim:
    """A line "there all the time": how far it stands out of each rest, or each part of one."""
    recording, courses = recordings[name], []
    for rest in rests(recording):
        t, values = readings(recording, rest)
        for rows in np.array_split(np.arange(len(t)), parts):
            least = [prominence(t[rows], values[rows, c], at) for c in channels]
            courses.append(float(np.median(least)))
    there = [series > VISIBLE for series in courses]
    # Weak lines need not show in each rest: together they must (mean square of Rayleigh draws).
    together = float((np.square(courses) * np.log(2.0)).sum())
    chance = float(np.exp(-together) * sum(_powers(together, len(courses))))
    gone = max(courses) > VISIBLE and (min(courses) < FAINT or min(courses) < 0.05 * max(courses))
    truth: Truth = "false" if gone or chance > 0.001 else "true" if any(there) else "cannot tell"
    shown = ", ".join(f"{series:.1f}" for series in courses)
    where = ", ".join(CHANNELS[c] for c in channels)
    return Claim(
        name,
        bilingual(f"a line at {at:g} Hz, there all the time", f"{at:g} Hz处始终存在的谱线"),
        truth,
        bilingual(
            f"amplitude over its surroundings in {where}, rest by rest: {shown} (noise: 1)",
            f"{where}中幅值与邻域之比，逐段：{shown}（噪声为1）",
        ),
        lambda answer: bool(lines_at(answer, at, 0.02)),
    )


def _powers(x: float, count: int) -> list[float]:
    """Terms of the survival function of a sum of `count` exponential draws: xᵏ/k!."""
    terms = [1.0]
    for k in range(1, count):
        terms.append(terms[-1] * x / k)
    return terms


def _walk(recordings: Recordings, name: str, channels: tuple[int, ...], en: str, zh: str) -> Claim:
    tried = wander(recordings[name], channels)
    truth: Truth = (
        "true"
        if tried.verdict == "true"
        else "false"
        if tried.verdict == "false"
        else "cannot tell"
    )
    return Claim(
        name,
        bilingual(f"biases of the {en} wander", f"{zh}零偏随机游走"),
        truth,
        bilingual(
            "second less first halves of the rests: so much by noise alone p = "
            f"{tried.p_noise:.2g}, so little by a walk that makes the misfit between the rests "
            f"p = {tried.p_walk:.2g}",
            f"各静止段后半减前半：仅由噪声引起的概率{tried.p_noise:.2g}，"
            f"由足以造成位置间残差的随机游走引起的概率{tried.p_walk:.2g}",
        ),
        lambda answer: any(
            CHANNELS[c] in each["channels"]
            for each in findings(answer, "bias_random_walk")
            for c in channels
        ),
    )


def _bursts(recordings: Recordings) -> Claim:
    recording, shown = recordings[SECOND], []
    for rest in rests(recording):
        _, values = readings(recording, rest)
        off = np.abs(values[:, 3:] - np.median(values[:, 3:], axis=0)).max(axis=1)
        shown.append((float(off[:50].max()), float(off[-50:].max())))
    truth: Truth = "true" if sum(max(pair) > MOVED for pair in shown) > 1 else "false"
    words = ", ".join(f"{a:.2f}/{b:.2f}" for a, b in shown)
    return Claim(
        SECOND,
        bilingual(
            "four bursts that fade, at 505, 867, 1240 and 1301 s",
            "四次衰减振荡（505、867、1240、1301 s）",
        ),
        truth,
        bilingual(
            f"largest deviation in the first/last second of each rest, m/s²: {words}; only z up "
            "was handled while labelled as a rest",
            f"各静止段首/末1 s最大偏离（m/s²）：{words}；仅z朝上段在标签内有搬动",
        ),
        lambda answer: any(
            parameter(each, "decay") is not None for each in findings(answer, "unnamed")
        ),
    )


def _products(recordings: Recordings) -> Claim:
    nearest, zero = (dead_zone_misfit(recordings[SHAFT], towards_zero=way) for way in (False, True))
    truth: Truth = "false" if zero < 0.7 * nearest else "cannot tell"
    return Claim(
        SHAFT,
        bilingual(
            "accelerometer y follows products and squares of the other forces",
            "加速度计y跟随其他轴比力的乘积与平方",
        ),
        truth,
        bilingual(
            f"misfit over the angle {1e3 * nearest:.1f} mm/s² if readings are rounded, "
            f"{1e3 * zero:.1f} if they are cut off towards zero: mostly a matter of rounding",
            f"随角度残差：四舍五入{1e3 * nearest:.1f} mm/s²，"
            f"向零截断{1e3 * zero:.1f} mm/s²：主要为截断所致",
        ),
        lambda answer: any(
            any(word in str(each["follows"]) for word in ("product", "squares"))
            for each in findings(answer, "unnamed", channel="accel_y")
        ),
    )


def _stepper(recordings: Recordings) -> Claim:
    at, coherence = line_shared(recordings[SHAFT])
    return Claim(
        SHAFT,
        bilingual(f"a line at {at:.2f} Hz beyond the motion", f"运动以外的{at:.2f} Hz谱线"),
        "false" if coherence > 0.95 else "cannot tell",
        bilingual(
            f"the encoder sees it, too: coherence with the gyro {coherence:.4f}; it is motion, "
            "which a smoothed encoder rate damps",
            f"编码器同样可见，与陀螺相干度{coherence:.4f}：属真实运动，被编码器速率的平滑削弱",
        ),
        lambda answer: bool(lines_at(answer, at, 0.1)),
    )


def _jump(recordings: Recordings) -> Claim:
    when, until = 33.14, 34.86
    jump = jump_at(recordings[SHAFT], "gyro_z", when)
    brief = excursion(recordings[SHAFT], "gyro_z", when, until)
    value, u, off, scatter = np.degrees([jump.value, jump.u, brief.value, brief.u])
    return Claim(
        SHAFT,
        bilingual(f"gyro z jumps at {when:.1f} s", f"陀螺z在{when:.1f} s处阶跃"),
        "true" if abs(value) > 4.0 * u else "false",
        bilingual(
            f"mean of the strokes after less before: {value:.3f} ± {u:.3f} deg/s; between "
            f"{when:.1f} and {until:.1f} s it is off by {off:.2f} ± {scatter:.2f} deg/s of the "
            "same place in other strokes: brief, no bias",
            f"其后与其前各往复周期均值之差：{value:.3f} ± {u:.3f} °/s；"
            f"{when:.1f}～{until:.1f} s与其他周期同一位置相差{off:.2f} ± {scatter:.2f} °/s："
            "短暂扰动，并非零偏",
        ),
        lambda answer: any(
            "jumps" in str(each["follows"]) or each["effect"] == "bias_step"
            for each in findings(answer, "bias_step", "unnamed", channel="gyro_z")
        ),
    )


def _as_many_as_rests(recordings: Recordings) -> Claim:
    """Six rests cannot try a model of six parameters a gyro."""
    directions, means = means_of(recordings[BENCH])
    pairs = [np.degrees(means[np.abs(directions[:, a]) > 0, 0].mean()) for a in range(3)]
    shown = ", ".join(f"{value:.4f}" for value in pairs)
    return Claim(
        BENCH,
        bilingual("biases of the gyros follow acceleration squared", "陀螺零偏随加速度平方变化"),
        "cannot tell",
        bilingual(
            f"gyro x, mean of each pair of rests in the order of time: {shown} deg/s. Bias, "
            "g- and g²-sensitivity are six parameters and fit any six rests; a slow drift fits too",
            f"陀螺x各对位置均值（按时间）：{shown} °/s。零偏、g与g²灵敏度共六个参数，"
            "任意六个位置均可吻合；缓慢漂移同样吻合",
        ),
        lambda answer: bool(findings(answer, "gyro_g2_sensitivity")),
    )
