"""evidence.html: the message on the first screen, then pictures, tables and every failure."""

from collections.abc import Sequence
from pathlib import Path

from tasks.rendering import inline, page
from tasks.words import Sayable, clauses
from tests.proof.text import Text, bilingual
from tests.proof.trial.evidence import (
    COLUMNS,
    COSTS,
    FAILURES,
    SUMMARY,
    Trial,
    besides,
    cells,
    cost_cells,
    failure_cells,
    summary,
)
from tests.proof.trial.failures import KINDS, failures
from tests.proof.trial.figures import costs, counting, figures, percent
from tests.proof.trial.pictures.cases import cases_svg
from tests.proof.trial.pictures.cost import cost_svg
from tests.proof.trial.pictures.headline import headline_svg
from tests.proof.trial.pictures.power import effects_svg, families_svg
from tests.proof.trial.score import Score
from tests.proof.trial.table import by_effect, rows_of, totals_of

TEMPLATE = Path(__file__).parent / "templates" / "evidence.html"
PICTURES = {
    "headline": headline_svg, "cost": cost_svg, "families": families_svg,
    "effects": effects_svg, "cases": cases_svg,
}  # fmt: skip

Table = tuple[Sequence[Sayable], Sequence[Sequence[Sayable]], tuple[int, ...]]


def evidence_html(trial: Trial, extra_sections: Sequence[str] = ()) -> str:
    """The HTML of a trial, in both languages.

    extra_sections: HTML that stands behind the failures: the peers, real recordings.
    """
    scores = trial.scores
    return page(
        TEMPLATE,
        lead=lead(scores),
        figures=figures(scores),
        besides=besides(trial),
        costs=costs(scores),
        pictures={name: inline(draw(scores)) for name, draw in PICTURES.items()},
        by_effect=_table(COSTS, [cost_cells(row) for row in by_effect(scores)]),
        failure_columns=FAILURES,
        failures=_failures(scores),
        extra_sections=[inline(section) for section in extra_sections],
        origin=_origin(trial),
        summary=_table(SUMMARY, summary(trial)),
        totals=_table(COLUMNS, [cells(row, True) for row in totals_of(scores).values()]),
        rows=_table(COLUMNS, [cells(row, False) for row in rows_of(scores)]),
    )


def lead(scores: Sequence[Score]) -> Text:
    """The whole page in one sentence."""
    hidden = [score for score in scores if score.effects]
    known = [score.cost for score in hidden if score.cost is not None]
    off = percent(counting(cost.before > 1.0 for cost in known))
    still = percent(counting(cost.after > 1.0 for cost in known))
    blind = percent(counting(cost.unnoticed for cost in known))
    right = percent(counting(score.right_or_twin for score in hidden if score.has_a_name))
    return bilingual(
        f"{len(hidden)} of {len(scores)} recordings hide physics that the standard's model leaves "
        f"out: its certificate is then wrong by more than it admits in {off} of them, and in "
        f"{blind} nothing would have been noticed; explain names it right in {right}, and with "
        f"that taken off {still} stay wrong.",
        f"{len(scores)}个记录中有{len(hidden)}个隐藏了规范模型未包含的物理因素：其中{off}的证书"
        f"偏差超过所声明的不确定度，{blind}不会被察觉；失配解释正确命名了其中的{right}，扣除之后"
        f"仍有偏差的为{still}。",
    )


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    """Head, rows, and every column but the first set to the right."""
    return head, rows, tuple(range(1, len(head)))


def _failures(scores: Sequence[Score]) -> list[list[Sayable]]:
    rows: list[list[Sayable]] = []
    for failure in failures(scores):
        number, _, *others, _ = failure_cells(failure, "")
        rows.append([number, KINDS[failure.kind], *others, clauses(failure.causes)])
    return rows


def _origin(trial: Trial) -> list[tuple[str, str]]:
    machine = trial.machine
    return [
        ("seed", f"{trial.seed}"),
        ("to repeat", trial.command),
        ("code", trial.code_version),
        ("Python, numpy, scipy", f"{machine.python}, {machine.numpy}, {machine.scipy}"),
        ("mimucal", machine.mimucal),
        ("machine", f"{machine.system}, {machine.cores} cores, {trial.seconds / 60:.1f} min"),
        ("SHA-256 of seals.txt", trial.seals),
    ]
