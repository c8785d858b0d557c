"""What the evidence page says, in both languages."""

from collections.abc import Sequence

from tests.proof.text import Text
from tests.proof.trial.figures import counting, percent
from tests.proof.trial.score import Score

STYLE = """<style>
.tiles { display: grid; grid-template-columns: repeat(6, 1fr); gap: .7em; margin: 1em 0; }
.tile { border: 1px solid #ddd; border-top: 4px solid #888; border-radius: 4px;
  padding: .5em .7em; display: flex; flex-direction: column; line-height: 1.3; }
.tile b { font-size: 1.65em; color: #222; } .tile span { font-size: .87em; color: #222; }
.tile span.quiet { color: #666; margin-top: auto; padding-top: .4em; }
.tile.good { border-top-color: #14691b; } .tile.bad { border-top-color: #a1190d; }
details { margin: .8em 0; } summary { cursor: pointer; color: #0b5d91; }
details table { font-size: .87em; }
@media (max-width: 50em) { .tiles { grid-template-columns: repeat(2, 1fr); } }
</style>"""
TITLE: Text = ("The sealed trial: what explain finds", "密封试验：失配解释能发现什么")
HEADLINE: Text = (
    "Left: the share of recordings with one effect of the catalogue in which it was detected and "
    "named, over how visible it is, beside the limit that no detector can beat. Right: the same "
    "recordings by how much of the effect the standard's parameters absorb.",
    "左：单一目录内因素的记录中被检出与正确命名的比例，横轴为可见度，绿线为任何检测器都无法超过"
    "的极限。右：同一批记录，按规范模型参数吸收该因素信号功率的比例分布。",
)
ASKED_TITLE: Text = ("Asked and reached", "要求与结果")
ASKED_HEAD: tuple[Text, ...] = (
    ("asked", "要求"),
    ("reached", "结果"),
    ("", ""),
    ("of [95 % interval, %]", "基数［95 %区间，%］"),
)
ASKED: Text = (
    "Intervals are Wilson's, 95 %: with no false alarm in 120 clean recordings the true rate may "
    "still be 3 %. Right and closed: one effect of the catalogue alone. A wrong name: one that is "
    "neither true nor in a pair that holds the truth.",
    "区间为Wilson 95 %区间：120个无隐藏因素的记录中即使无一误报，真实误报率仍可能达3 %。正确率"
    "与闭合比例：仅含单一目录内因素的记录。错误名称：既非真值，其不可区分项中亦不含真值。",
)
COST_TITLE: Text = ("What it costs to miss it", "漏掉它的代价")
COST_HEAD: tuple[Text, ...] = (
    ("as the clauses give it", "按条款"),
    ("with explain", "经失配解释"),
)
COST: Text = (
    "Each recording was calibrated by the clauses three times: as read, with what explain named "
    "taken off first (`calibrate --terms`), and, behind the seal, the same run and noise without "
    "the effects. An error is the difference from the last, in the U that the certificate itself "
    "states. The verdict is that of a recalibration: no value may have moved by more than 4 U "
    "since the last certificate, the tightest limits that an accuracy ratio of 4 to 1 allows; the "
    "unit's own changes are drawn so that nine units of ten conform, and where U itself has grown "
    "beyond the limits nothing is decided. Noticed: the clauses' own evaluation remarks on more "
    "residuals (at 1 %) than without the effects; with explain: anything was found. What was "
    "found and left unnamed cannot be taken off and stays.",
    "每个记录按条款校准三次：按原读数；先扣除已命名的因素（`calibrate --terms`）；以及密封保存"
    "的、同一过程同一噪声但不含这些因素的记录。偏差为与后者之差，以证书自身声明的U表示。判定按"
    "复校：各值自上次证书以来的变化不得超过4U（测试准确度比4:1所允许的最严限值）；器件自身的变"
    "化随机抽取，使十分之九的器件合格；U本身超过限值时不作判定。察觉：条款自身的评定对残差的提"
    "示（1 %水平）多于不含因素时；失配解释一栏：有任何发现。已发现但未命名的因素无法扣除，保留"
    "不变。",
)
DUMBBELL: Text = (
    "The largest error of any value on the certificate, in its stated U. Left of the black line "
    "the certificate holds what it says.",
    "证书中最大偏差，以其声明的U表示。黑线左侧表示证书所述成立。",
)
BY_EFFECT: Text = ("The same by effect, in figures", "按因素列出的数值")
POWER_TITLE: Text = ("Power", "检出能力")
FAMILIES: Text = (
    "Effects alone, pooled by family: bars are Wilson's 95 % intervals. The limit is the power of "
    "a χ² test that knows the effect's form and its number of parameters, at 1 % false alarms, in "
    "the mean over the family; explain has to look for all of them at once, and does not know.",
    "按类别合并的单一因素结果，短线为Wilson 95 %区间。极限为已知因素形式及其参数个数的χ²检验在1 %"
    "误报率下的检出概率（类内平均）；失配解释须同时搜索全部因素，且事先不知是哪一个。",
)
EFFECTS: Text = (
    "Each effect: two recordings at z 10, 30 and 100 and one at 5 are too few for a curve of its "
    "own, so they stand as squares below, and the curves are those of its family. The Earth turns "
    "as it does, at whatever z that is.",
    "各因素：z为10、30、100时各两个记录，z为5时一个，不足以单独成曲线，故以方格列于下方，曲线为"
    "其所属类别的合并结果。",
)
FAILURES_TITLE: Text = ("What fails, and why", "失败的案例及原因")
PROTOCOL_TITLE: Text = ("Protocol", "试验方法")
PROTOCOL: Text = (
    "Recordings come from an independent plant, which works with kinematics, filters and clocks "
    "and shares no code with what explains them. What each one hides is drawn from the seed, "
    "written apart and sealed by its SHA-256 before anything is explained. The processes that "
    "explain get the folder of one recording and nothing else. Then the seals are checked and "
    "opened. z is what is left of an effect after the standard's parameters took their part, "
    "beside the noise.",
    "试验记录由独立的仿真装置产生：按运动学、滤波与时钟逐级模拟，与解释程序不共用任何代码。各记"
    "录隐藏的物理因素由种子抽取，另行存放，并在解释开始之前以SHA-256密封。解释进程只得到单个记"
    "录的文件夹。解释结束后核对并拆封。z为规范模型参数吸收之后所余信号与噪声之比。",
)
RULES: Text = (
    "Detected: anything was found. Right: the first name is the truth. Or its twin: that name, or "
    "one that is listed as indistinguishable from it. Any wrong: a name that is not in the truth, "
    "even beside a right one; for what is outside the catalogue any name is wrong. Gap closed: 1 "
    "− Σ|truth − found|²/σ² / Σ|truth − nominal|²/σ², σ the white noise of the grade, the median; "
    "of what can be: beside the errors that noise alone leaves in the standard's parameters, "
    "which nobody who has to fit them can take away. Concealed: the share of the effect's power "
    "that the standard's parameters absorb. Off: by how many of its own U the value of the "
    "certificate that suffers most differs, by the clauses, when the effects are there; then: "
    "with what was named taken off first.",
    "检出：有任何发现。正确：首个名称即真值。或其孪生：首个名称或与其不可区分者之一为真值。任一"
    "错误：出现真值以外的名称，即使另有正确名称；对目录外因素，任何名称均为错误。缺口闭合：1 − Σ|"
    "真值 − 解释|²/σ² / Σ|真值 − 规范模型|²/σ²，σ为该等级的白噪声，取中位数；占可闭合量：扣除噪"
    "声本身给规范模型参数带来的、任何拟合都无法消除的误差。隐藏比例：规范模型参数吸收的信号功率"
    "比例。off：按条款计算时，证书中受影响最大的值因这些因素而改变多少倍其扩展不确定度U；then："
    "先扣除已命名的因素之后。",
)
ORIGIN_TITLE: Text = ("Origin", "来源")
CASES_TITLE: Text = ("Every case", "逐例结果")
CASES: Text = (
    "Each square is one recording. Right is the name; for what is outside the catalogue (x_…), to "
    "leave it unnamed, and for another gravity, which the scale factors take whole, to tell "
    "nothing.",
    "每格为一个记录。正确：名称即真值；对目录外因素（x_…）为不予命名；对标度因数完全吸收的重力"
    "差异为不作判断。",
)
TOTALS_TITLE: Text = ("In all", "总计")
ALL_COLUMNS: Text = ("The same with every column", "全部各列")
ALL_ROWS: Text = ("By effect and visibility", "按因素与可见度")


def message(scores: Sequence[Score]) -> Text:
    """The whole page in one sentence."""
    hidden = [each for each in scores if each.effects]
    known = [each.cost for each in hidden if each.cost is not None]
    off = percent(counting(cost.before > 1.0 for cost in known))
    still = percent(counting(cost.after > 1.0 for cost in known))
    blind = percent(counting(cost.unnoticed for cost in known))
    right = percent(counting(each.right_or_twin for each in hidden if each.has_a_name))
    return (
        f"{len(hidden)} of {len(scores)} recordings hide physics that the standard's model leaves "
        f"out: its certificate is then wrong by more than it admits in {off} of them, and in "
        f"{blind} nothing would have been noticed; explain names it right in {right}, and with "
        f"that taken off {still} stay wrong.",
        f"{len(scores)}个记录中有{len(hidden)}个隐藏了规范模型未包含的物理因素：其中{off}的证书"
        f"偏差超过所声明的不确定度，{blind}不会被察觉；失配解释正确命名了其中的{right}，扣除之后"
        f"仍有偏差的为{still}。",
    )
