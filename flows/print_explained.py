"""What the command line prints of an explanation, for a person."""

from rich.console import Console
from rich.table import Table
from rich.text import Text

from flows.printing import stdout
from schemas.discrepancy import Discrepancy, FindingSaid
from schemas.discrepancy import Verdict as Answer
from tasks.certificate.names import item_name
from tasks.explain.correction.consequences import moved_by
from tasks.stages.explain import Explained
from tasks.words.rounding import column
from tasks.words.units import unit_text

COLOURS: dict[Answer, str] = {
    "no_mismatch": "green", "explained": "green", "partly_explained": "yellow",
    "unexplained": "red",
}  # fmt: skip
MOST_CONSEQUENCES = 8  # rows of a finding; the report has them all


def print_explained(explained: Explained) -> None:
    """The verdict, what was found with its parameters, what it matters, and the files."""
    discrepancy, console = explained.discrepancy, stdout()
    said = discrepancy.verdict.replace("_", " ")
    console.print(f"[bold {COLOURS[discrepancy.verdict]}]{said}[/] ", end="")
    console.print(f"({discrepancy.recording_id})", markup=False)
    console.print(discrepancy.statement.en, markup=False)
    if discrepancy.findings:
        console.print(_table(discrepancy))
    for finding in discrepancy.findings:
        _print_finding(console, finding)
    for remark in discrepancy.remarks:
        console.print("[dim]·[/] ", end="")
        console.print(remark.en, markup=False)
    for path in explained.files:
        print(path)


def _table(discrepancy: Discrepancy) -> Table:
    table = Table()
    for name, justify in (("missing", "left"), ("channels", "left"), ("parameter", "left"),
                          ("value", "right"), ("U (k = 2)", "right"), ("unit", "left"),
                          ("ΔBIC", "right")):  # fmt: skip
        table.add_column(name, justify=justify)  # type: ignore[arg-type]
    for finding in discrepancy.findings:
        for row, cells in enumerate(_parameters(finding) or [("–", "–", "–", "")]):
            first = row == 0
            table.add_row(
                Text(finding.effect if first else ""),
                Text(", ".join(finding.channels) if first else ""),
                *map(Text, cells),
                Text(f"{finding.evidence.delta_bic:.0f}" if first else ""),
                end_section=row == max(len(finding.parameters), 1) - 1,
            )
    return table


def _parameters(finding: FindingSaid) -> list[tuple[str, str, str, str]]:
    """Name, value, U and unit of each parameter, rounded as results are."""
    rows = []
    for parameter in finding.parameters:
        texts = column([parameter.value], [2.0 * parameter.u], 2.0)
        power = f"×10^{texts.exponent} " if texts.exponent else ""
        rows.append(
            (
                parameter.name,
                texts.values[0] or "–",
                texts.uncertainties[0] or "–",
                power + unit_text(parameter.unit),
            )
        )
    return rows


def _print_finding(console: Console, finding: FindingSaid) -> None:
    """The sentence of a finding, and the elements of the certificate that it moves most."""
    console.print(f"[bold]{finding.title.en}[/]")
    console.print(finding.statement.en, markup=False)
    listed = sorted(finding.consequences, key=moved_by, reverse=True)
    for seen in listed[:MOST_CONSEQUENCES]:
        U, unit = seen.U, unit_text(seen.unit)
        texts = column([seen.before, seen.after], [U, U], 2.0)
        before, after = (value or "–" for value in texts.values)
        power = f"·10^{texts.exponent}" if texts.exponent else ""
        line = f"  {item_name(seen.item)[1]} {seen.element}: {before} → {after}{power} {unit}"
        console.print(f"{line} ({moved_by(seen):.1f} U)" if U else line, markup=False)
    if len(listed) > MOST_CONSEQUENCES:
        left = len(listed) - MOST_CONSEQUENCES
        console.print(f"  and {left} elements more, in the report", style="dim")
    for change in finding.verdict_changes:
        said = f"  verdict of {item_name(change.item)[1]}: {change.before} → {change.after}"
        console.print(said, style="bold", markup=False)
