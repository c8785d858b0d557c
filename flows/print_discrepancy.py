"""Prints a discrepancy."""

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table
from rich.text import Text

from flows.printing import stdout
from schemas.discrepancy import Discrepancy, ReportedFinding, Verdict
from tasks.explain.correction.consequences import moved_by
from tasks.explain.report import names
from tasks.stages.explain import Explained
from tasks.words import say
from tasks.words.quantities import chi2, percent, quantities
from tasks.words.rounding import USUAL_K

COLOURS: dict[Verdict, str] = {
    "no_mismatch": "green", "explained": "green", "partly_explained": "yellow",
    "unexplained": "red",
}  # fmt: skip
COLUMNS = ("missing", "share", "channels", "parameter", "value", "U (k = 2)", "unit")
NUMERIC = ("share", "value", "U (k = 2)")
MAX_CONSEQUENCES = 8  # rows of a finding; the report has them all


def print_discrepancy(explained: Explained) -> None:
    """Print the verdict, the findings with their parameters, their consequences, and the files."""
    discrepancy, console = explained.discrepancy, stdout()
    verdict = discrepancy.verdict.replace("_", " ")
    console.print(f"[bold {COLOURS[discrepancy.verdict]}]{verdict}[/] ", end="")
    console.print(f"({discrepancy.recording_id})", markup=False)
    console.print(discrepancy.statement.en, markup=False)
    if discrepancy.findings:
        console.print(_table(discrepancy))
    for number, finding in enumerate(discrepancy.findings, 1):
        console.print(f"[bold]{number}[/] ", end="")
        _print_finding(console, finding)
    if discrepancy.left_over:
        left = (f"{channel} {chi2(value)}" for channel, value in discrepancy.left_over.items())
        console.print(f"left over, χ² per degree of freedom: {', '.join(left)}", markup=False)
    for remark in discrepancy.remarks:
        console.print("[dim]·[/] ", end="")
        console.print(remark.en, markup=False)
    for path in explained.files:
        print(path)


def _table(discrepancy: Discrepancy) -> Table:
    table = Table()
    for name in COLUMNS:
        table.add_column(name, justify="right" if name in NUMERIC else "left")
    for finding in discrepancy.findings:
        *others, last = _parameters(finding) or [("–", "–", "–", "")]
        first = (finding.effect, percent(finding.share), ", ".join(finding.channels))
        for cells in (*others, last):
            table.add_row(*map(Text, (*first, *cells)), end_section=cells is last)
            first = ("", "", "")
    return table


def _parameters(finding: ReportedFinding) -> Sequence[tuple[str, str, str, str]]:
    """Name, value, U and unit of each parameter, as in the report."""
    made = [(p.name, quantities([p.value], USUAL_K * p.u, p.unit)) for p in finding.parameters]
    return [
        (name, each.values[0] or "–", each.uncertainties[0] or "–", each.unit)
        for name, each in made
    ]


def _print_finding(console: Console, finding: ReportedFinding) -> None:
    """Print the sentence of a finding, and the certificate elements that it changes most."""
    console.print(finding.statement.en, markup=False)
    listed = sorted(finding.consequences, key=moved_by, reverse=True)
    for moved in listed[:MAX_CONSEQUENCES]:
        made = quantities([moved.before, moved.after], moved.U, moved.unit)
        before, after = (value or "–" for value in made.values)
        element = say(names.element_title(moved.item, moved.element), "en")
        line = f"  {element}: {before} → {after} {made.unit}".rstrip()
        console.print(f"{line} ({moved_by(moved):.1f} U)" if moved.U else line, markup=False)
    if len(listed) > MAX_CONSEQUENCES:
        left = len(listed) - MAX_CONSEQUENCES
        console.print(f"  and {left} elements more, in the report", style="dim")
    for change in finding.verdict_changes:
        item, verdicts = names.element_title(change.item, ""), names.change_title(change)
        line = f"  verdict of {say(item, 'en')}: {say(verdicts, 'en')}"
        console.print(line, style="bold", markup=False)
