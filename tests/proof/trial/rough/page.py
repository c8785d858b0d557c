"""rough.html and rough.md: what engines said of the same sealed rough recordings."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from tasks.rendering import page
from tests.proof.report import table
from tests.proof.text import Text, bilingual
from tests.proof.trial.rough.score import RoughScore
from tests.proof.trial.rough.table import AGREE, CASES, COLUMNS, agreement, cases, rows_rough

TEMPLATE = Path(__file__).parent / "templates" / "rough.html"
TITLE: Text = bilingual("The sealed trial on rough recordings", "粗糙记录的密封试验")
RULES: Text = bilingual(
    "References err (coarse or late encoders, tracked bodies moved by hand), loggers change rows "
    "and codes, effects come in forms that no term has, and two or three strong ones outside the "
    "catalogue come at once. A wrong name: a name of the catalogue that is neither among what is "
    "hidden or brought along by the reference, nor in a group with such a one; the latter are "
    "counted apart. z: how far an effect stands above everything else in the recording, after the "
    "standard's parameters took their part. Intervals: stated parameters whose 95 % interval "
    "holds the truth, where both mean the same. Rates with Wilson's 95 % interval.",
    "参考本身有误差（粗分度或滞后的编码器、手持运动的跟踪刚体），记录器改变行与码，因素的形式与模型项不同，"
    "并有两三个目录外的强因素同时存在。错误名称：既不属于隐藏因素或参考带来的因素，也不与其同组的目录名称；"
    "后者单独计数。z：规范模型参数吸收之后，该因素高出记录中其余一切的倍数。区间：含义相同的参数中，"
    "所声明95 %区间包含真值者。比率附Wilson 95 %区间。",
)

Answers = Mapping[str, Sequence[RoughScore]]


def rough_html(seed: int, seals: str, answers: Answers) -> str:
    """The page of a trial. answers: the scores by engine."""
    tables = [
        (engine, _rows(scores), agreement(scores), cases(scores))
        for engine, scores in answers.items()
    ]
    return page(TEMPLATE, title=TITLE, rules=RULES, seed=seed, seals=seals, tables=tables,
                columns=COLUMNS, agree=AGREE, cases=CASES)  # fmt: skip


def rough_markdown(seed: int, seals: str, answers: Answers) -> str:
    """The same tables."""
    lines = [f"# {TITLE.en}, seed {seed}", "", RULES.en, "", f"SHA-256 of the seals: {seals}", ""]
    for engine, scores in answers.items():
        lines += [f"## {engine}", "", *table(COLUMNS, _rows(scores)), ""]
        lines += [*table(AGREE, agreement(scores)), "", *table(CASES, cases(scores)), ""]
    return "\n".join(lines)


def _rows(scores: Sequence[RoughScore]) -> list[list[str]]:
    return [row.cells() for row in rows_rough(scores)]
