"""evidence.html: what the trial was, its pictures and its tables, in one file."""

from collections.abc import Sequence
from html import escape

from tasks.explain.report.look import both, document, table
from tasks.model.term import Text
from tasks.prove.trial.evidence import COLUMNS, SUMMARY, Trial, besides, cells, summary
from tasks.prove.trial.picture import cases_svg, outcome, power_svg
from tasks.prove.trial.score import Score
from tasks.prove.trial.table import rows_of, totals_of

TITLE: Text = ("The sealed trial: what explain finds", "密封试验：失配解释能发现什么")
METHOD: Text = (
    "Recordings come from an independent plant, which works with kinematics, filters and clocks "
    "and shares no code with what explains them. What each one hides is drawn from the seed, "
    "written apart and sealed by its SHA-256 before anything is explained. The processes "
    "that explain get the folder of one recording and nothing else. Then the seals are checked "
    "and opened. z is what is left of an effect after the standard's parameters took their part, "
    "beside the noise; no detector, even one that knows the effect's form, sees more.",
    "试验记录由独立的仿真装置产生：按运动学、滤波与时钟逐级模拟，与解释程序不共用任何代码。各记录隐藏的物理因素由种子"
    "抽取，另行存放，并在解释开始之前以SHA-256密封。解释进程只得到单个记录的文件夹。解释结束后核对并拆封。z为规范模型参数"
    "吸收之后所余信号与噪声之比，即使已知该因素形式的检测器也不可能看到更多。",
)
POWER: Text = (
    "Effects of the catalogue, alone. Bars are 95 % intervals (Wilson).",
    "目录内因素单独出现时的结果；短线为95 %区间（Wilson）。",
)
CASES: Text = (
    "Each square is one recording. Right is the name; for what is outside the catalogue (x_…), "
    "to leave it unnamed, and for another gravity, which the scale factors take whole, to tell "
    "nothing.",
    "每格为一个记录。正确：名称即真值；对目录外因素（x_…）为不予命名；对标度因数完全吸收的重力差异为不作判断。",
)
RULES: Text = (
    "Detected: anything was found. Right: the first name is the truth. Or its twin: that name, or "
    "one that is listed as indistinguishable from it. Any wrong: a name that is not in the truth, "
    "even beside a right one; for what is outside the catalogue any name is wrong. Gap closed: "
    "1 − Σ|truth − found|²/σ² / Σ|truth − nominal|²/σ², σ the white noise of the grade, the "
    "median; of what can be: beside the errors that noise alone leaves in the standard's "
    "parameters, which nobody who has to fit them can take away. Certificate off: by how many of "
    "its own U the value that suffers most changes, by the clauses of JJF 2003-2022, when the "
    "effects are there.",
    "检出：有任何发现。正确：首个名称即真值。或其孪生：首个名称或与其不可区分者之一为真值。任一错误：出现真值以外的名称，"
    "即使另有正确名称；对目录外因素，任何名称均为错误。"
    "缺口闭合：1 − Σ|真值 − 解释|²/σ² / Σ|真值 − 规范模型|²/σ²，σ为该等级的白噪声，取中位数；"
    "占可闭合量：扣除噪声本身给规范模型参数带来的、任何拟合都无法消除的误差。"
    "证书偏差：按JJF 2003—2022条款计算时，受影响最大的值因这些因素而改变多少倍其扩展不确定度U。",
)


def page(trial: Trial) -> str:
    """The HTML of a trial, in both languages."""
    numbers = tuple(range(1, len(COLUMNS)))
    totals = [_cells(cells(row, True)) for row in totals_of(trial.scores).values()]
    rows = [_cells(cells(row, False)) for row in rows_of(trial.scores)]
    return document(
        TITLE[0],
        [
            f"<h1>{both(TITLE)}</h1>",
            f'<p class="lead">{both(METHOD)}</p>',
            _summary(trial),
            table(["", ""], [_cells(each) for each in besides(trial)]),
            f"<p>{both(RULES)}</p>",
            *_heading("Power", "检出能力"),
            _figure(power_svg(trial.scores), POWER),
            *_heading("Every case", "逐例结果"),
            _figure(cases_svg(trial.scores), CASES),
            *_heading("In all", "总计"),
            table(list(COLUMNS), totals, numbers),
            *_heading("By effect and visibility", "按因素与可见度"),
            table(list(COLUMNS), rows, numbers),
            *_heading("Names that were wrong", "错误的名称"),
            _wrong(trial),
            *_heading("Origin", "来源"),
            f"<p>seed {trial.seed}, {escape(trial.code_version)}, SHA-256 of seals.txt "
            f"<code>{trial.seals}</code></p>",
        ],
    )


def _summary(trial: Trial) -> str:
    rows = [_cells(each) for each in summary(trial)]
    return table(list(SUMMARY), rows, tuple(range(1, len(SUMMARY))))


def _wrong(trial: Trial) -> str:
    wrong = [each for each in trial.scores if each.wrong]
    if not wrong:
        return f"<p>{both(('None.', '无。'))}</p>"
    return table(
        ["recording", "truth", "z", "named", "wrong", "procedure", "outcome"],
        [_cells(_told(each)) for each in wrong],
    )


def _told(each: Score) -> list[str]:
    return [
        each.number,
        " + ".join(each.effects) or "clean",
        ", ".join(f"{z:.3g}" for z in each.z.values()),
        ", ".join(each.names),
        ", ".join(each.wrong),
        f"{each.conditions['procedure']}, {each.conditions['grade']}",
        outcome(each)[1],
    ]


def _cells(words: Sequence[str]) -> list[str]:
    return [escape(word) for word in words]


def _heading(en: str, zh: str) -> list[str]:
    return [f"<h2>{both((en, zh))}</h2>"]


def _figure(picture: str, caption: Text) -> str:
    return f"<figure>{picture}<figcaption>{both(caption)}</figcaption></figure>"
