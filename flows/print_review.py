"""Prints a review."""

from rich.table import Table
from rich.text import Text

from flows.printing import stdout
from schemas.review import Review, ReviewFinding
from tasks.stages.review import Reviewed
from tasks.words.quantities import quantities
from tasks.words.rounding import USUAL_K

COLUMNS = ("effect", "carrier", "since", "parameter", "value", "U (k = 2)", "unit", "runs")
NUMERIC = ("value", "U (k = 2)", "runs")


def print_review(reviewed: Reviewed) -> None:
    """Print the verdict, the common effects with their parameters, and the runs left out."""
    review, console = reviewed.review, stdout()
    console.print(f"{review.verdict.replace('_', ' ')} ({review.runs} runs)", markup=False)
    console.print(review.statement.en, markup=False)
    if review.findings:
        console.print(_table(review))
    for statement in [one.statement for one in review.findings] + [
        one.statement for one in review.sites
    ]:
        console.print(statement.en, markup=False)
    for skipped in review.skipped:
        console.print(f"left out: {skipped.run}: {skipped.why}", markup=False)
    for path in reviewed.files:
        print(path)


def _table(review: Review) -> Table:
    table = Table()
    for name in COLUMNS:
        table.add_column(name, justify="right" if name in NUMERIC else "left")
    for cells in (cells for finding in review.findings for cells in _rows(finding)):
        table.add_row(*map(Text, cells))
    return table


def _rows(finding: ReviewFinding) -> list[tuple[str, ...]]:
    since = finding.since.at if finding.since else "–"
    first = (finding.effect, f"{finding.level} {finding.carrier}", since)
    found: list[tuple[str, ...]] = []
    for p in finding.parameters:
        made = quantities([p.value], USUAL_K * p.u, p.unit)
        number = str(finding.evidence.runs) if not found else ""
        value, u = made.values[0] or "–", made.uncertainties[0] or "–"
        found.append((*(first if not found else ("", "", "")), p.name, value, u, made.unit, number))
    return found
