"""The section of evidence.html and evidence.md that holds the peers beside `explain`."""

from collections.abc import Sequence
from pathlib import Path

from tasks.rendering import page
from tests.proof.peers.score import PeerScore
from tests.proof.peers.table import Duties, duties_of
from tests.proof.report import table
from tests.proof.text import Text, bilingual
from tests.proof.trial.evidence import rate_words

TEMPLATE = Path(__file__).parent / "templates" / "section.html"
TITLE: Text = bilingual("What an engineer would use today", "与现有方法的对比")
METHOD: Text = bilingual(
    "The same recordings, inputs and held-out segments, answered by four peers: means of the "
    "residuals against a threshold; forward stepwise regression with BIC over a generic library; "
    "sparse regression (SINDy, pysindy); a Gaussian process for the discrepancy (Kennedy & "
    "O'Hagan). Their thresholds were set on clean recordings of other seeds, to about 1 % false "
    "alarms. Rows are whitened by the Allan variance for all that regress.",
    "四种现有方法使用相同的记录、输入和留出段：残差均值阈值；通用函数库上的BIC前向逐步回归；稀疏回归（SINDy，pysindy）；"
    "高斯过程失配项（Kennedy与O'Hagan）。其阈值以其他种子的无失配记录整定，虚警率约1 %。"
    "各回归方法均先按Allan方差白化。",
)
RULES: Text = bilingual(
    "Located: the channels named hold the largest share of what the standard's model leaves of "
    "the truth. Named: the first name is right, of the cases that have a name. Modelled: share of "
    "the gap closed, of means over the same 25 Hz blocks and against the same fit of the "
    "standard's model for everybody, the median. Shown: "
    "segments that the fit did not see are predicted better. Abstained: nothing found on a clean "
    "recording, no name given outside the catalogue. Two of the peers name nothing by their "
    "nature, and one of them models nothing.",
    "定位：所指通道占规范模型残余真值功率的最大份额。命名：在有正确名称的情形中首个名称正确。建模：缺口闭合份额，"
    "各方法均取相同25 Hz分块均值与同一规范模型拟合，取中位数。展示：对拟合未见的段预测更好。"
    "不作判断：无失配记录无发现，目录外因素不予命名。其中两种方法本身不命名，其一不建模。",
)
COLUMNS = (
    "case", "method", "cases", "detected", "located", "named", "any wrong", "gap closed",
    "shown", "abstained", "seconds",
)  # fmt: skip
METHOD_WORDS = {
    "mimucal": "mimucal explain",
    "residual_threshold": "residual threshold",
    "stepwise_bic": "stepwise BIC",
    "sindy": "SINDy",
    "gp_discrepancy": "Gaussian process",
}


def section(scores: Sequence[PeerScore]) -> str:
    """HTML in both languages; empty where no peer answered."""
    if not scores:
        return ""
    rows = [cells(duties) for duties in duties_of(scores)]
    return page(TEMPLATE, title=TITLE, method=METHOD, rules=RULES, columns=COLUMNS, rows=rows,
                numeric=range(2, len(COLUMNS)))  # fmt: skip


def markdown(scores: Sequence[PeerScore]) -> str:
    """The same table; empty where no peer answered."""
    if not scores:
        return ""
    rows = table(COLUMNS, map(cells, duties_of(scores)))
    return "\n".join([f"## {TITLE.en}", "", METHOD.en, "", *rows, "", RULES.en, ""])


def cells(duties: Duties) -> list[str]:
    """A row as words, in the order of COLUMNS."""
    rates = (duties.detected, duties.locate, duties.name, duties.wrong)
    gap = "–" if duties.model is None else f"{round(duties.model, 2) + 0.0:.2f}".replace("-", "−")
    return [
        duties.kind,
        METHOD_WORDS[duties.method],
        f"{duties.cases}",
        *(rate_words(rate, False) for rate in rates),
        gap,
        rate_words(duties.show, False),
        rate_words(duties.abstain, False),
        f"{duties.seconds:.1f}",
    ]
