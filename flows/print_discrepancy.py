"""Prints a discrepancy, and a review."""

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table
from rich.text import Text

from flows.print_calibration import column_title
from flows.printing import stdout
from schemas.discrepancy import Discrepancy, ReportedFinding, Verdict
from schemas.review import Review, ReviewFinding
from tasks.explain.correction.consequences import moved_by
from tasks.explain.report import names
from tasks.stages.explain import Explained
from tasks.stages.review import Reviewed
from tasks.words import message, say
from tasks.words.quantities import chi2, percent, quantities
from tasks.words.rounding import USUAL_K

COLOURS: dict[Verdict, str] = {
    "no_mismatch": "green", "explained": "green", "partly_explained": "yellow",
    "unexplained": "red",
}  # fmt: skip
COLUMNS = ("missing", "share", "channels", "parameter", "value", "U (k = 2)", "unit")
REVIEW_COLUMNS = ("effect", "carrier", "since", "parameter", "value", "U (k = 2)", "unit", "runs")
NUMERIC = ("share", "value", "U (k = 2)", "runs")
MAX_CONSEQUENCES = 8  # rows of a finding; the report has them all


def print_discrepancy(explained: Explained) -> None:
    """Print the verdict, the findings with their parameters, their consequences, and the files."""
    discrepancy, console = explained.discrepancy, stdout()
    verdict = say(message(f"report-{discrepancy.verdict}"))
    console.print(f"[bold {COLOURS[discrepancy.verdict]}]{verdict}[/] ", end="")
    console.print(f"({discrepancy.recording_id})", markup=False)
    console.print(say(discrepancy.statement), markup=False)
    if discrepancy.findings:
        console.print(_table(discrepancy))
    for number, finding in enumerate(discrepancy.findings, 1):
        console.print(f"[bold]{number}[/] ", end="")
        _print_finding(console, finding)
    if discrepancy.left_over:
        left = tuple(f"{name} {chi2(value)}" for name, value in discrepancy.left_over.items())
        console.print(say(message("flows-left-over", channels=left)), markup=False)
    for remark in discrepancy.remarks:
        console.print("[dim]·[/] ", end="")
        console.print(say(remark), markup=False)
    for path in explained.files:
        print(path)


def _headed(columns: Sequence[str]) -> Table:
    table = Table()
    for name in columns:
        table.add_column(column_title(name), justify="right" if name in NUMERIC else "left")
    return table


def _table(discrepancy: Discrepancy) -> Table:
    table = _headed(COLUMNS)
    for finding in discrepancy.findings:
        *others, last = _parameters(finding) or [("–", "–", "–", "")]
        first = (finding.effect, percent(finding.share), ", ".join(finding.channels))
        for cells in (*others, last):
            table.add_row(*map(Text, (*first, *cells)), end_section=cells is last)
            first = ("", "", "")
    return table


def _parameters(finding: ReportedFinding | ReviewFinding) -> Sequence[tuple[str, str, str, str]]:
    """Name, value, U and unit of each parameter, as in the report."""
    made = [(p.name, quantities([p.value], USUAL_K * p.u, p.unit)) for p in finding.parameters]
    return [
        (name, each.values[0] or "–", each.uncertainties[0] or "–", each.unit)
        for name, each in made
    ]


def _print_finding(console: Console, finding: ReportedFinding) -> None:
    """Print the sentence of a finding, and the certificate elements that it changes most."""
    console.print(say(finding.statement), markup=False)
    listed = sorted(finding.consequences, key=moved_by, reverse=True)
    for moved in listed[:MAX_CONSEQUENCES]:
        made = names.before_and_after(moved)
        before, after = (made.text(k) if made.values[k] else "–" for k in range(2))
        element = say(names.element_title(moved.item, moved.element))
        line = f"  {element}: {before} → {after}"
        times = names.shift_text(moved)
        console.print(f"{line}, {times} U" if times else line, markup=False)
    if len(listed) > MAX_CONSEQUENCES:
        left = len(listed) - MAX_CONSEQUENCES
        more = message("flows-more-elements", count=left)
        console.print(f"  {say(more)}", style="dim")
    for change in finding.verdict_changes:
        item, verdicts = names.element_title(change.item, ""), names.change_title(change)
        sentence = say(message("flows-verdict-of", item=item, change=verdicts))
        console.print(f"  {sentence}", style="bold", markup=False)


def print_review(reviewed: Reviewed) -> None:
    """Print the verdict, the common effects with their parameters, and the runs left out."""
    review, console = reviewed.review, stdout()
    verdict = say(message(f"report-{review.verdict}"))
    console.print(say(message("flows-of-runs", verdict=verdict, runs=review.runs)), markup=False)
    console.print(say(review.statement), markup=False)
    if review.findings:
        console.print(_review_table(review))
    for statement in [one.statement for one in review.findings] + [
        one.statement for one in review.sites
    ]:
        console.print(say(statement), markup=False)
    for skipped in review.skipped:
        left_out = message("flows-left-out", run=skipped.run, why=skipped.why)
        console.print(say(left_out), markup=False)
    for path in reviewed.files:
        print(path)


def _review_table(review: Review) -> Table:
    table = _headed(REVIEW_COLUMNS)
    for finding in review.findings:
        since = finding.since.at if finding.since else "–"
        first = (finding.effect, f"{finding.level} {finding.carrier}", since)
        runs = str(finding.evidence.runs)
        for cells in _parameters(finding):
            table.add_row(*map(Text, (*first, *cells, runs)))
            first, runs = ("", "", ""), ""
    return table
