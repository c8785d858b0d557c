"""Prints a re-processing report, an impact report, and what the store can do without."""

from flows.printing import print_rows, stdout
from schemas.history import Impact, Plan, Pruned, Reprocessing
from tasks.words.quantities import unit_text

SHOWN = 20  # rows of each table; the report has all


def print_plan(plan: Plan) -> None:
    """Print what would be done."""
    print(
        f"{plan.results} results of {len(plan.runs)} runs ({plan.rows} samples) would be made with "
        f"{plan.code_version}; {plan.done_before} were already"
    )
    for run in plan.runs:
        print(run)


def print_report(report: Reprocessing, out: str | None) -> None:
    """Print what was done and what differs: values by size of change, verdicts, certificates."""
    if report.changed:
        changes = [
            (c.run, f"{c.item}.{c.element}", _number(c.before), _number(c.after),
             _number(c.U_before), _number(c.U_after), _number(c.in_U), unit_text(c.unit))
            for c in report.changed
        ]  # fmt: skip
        columns = ("run", "element", "before", "after", "U before", "U", "change / U", "unit")
        print_rows(f"Changed: {_shown(len(changes))}", columns, changes[:SHOWN])
    if report.flips:
        verdicts = [
            (f.run, ".".join(n for n in (f.item, f.element) if n) or f.about, f.before, f.after)
            for f in report.flips
        ]
        of_verdict = ("run", "verdict of", "before", "after")
        print_rows(f"Verdicts: {_shown(len(verdicts))}", of_verdict, verdicts[:SHOWN])
    if report.certificates:
        papers = [
            (
                t.number,
                t.run,
                t.state,
                t.verdict,
                _number(t.largest_in_U),
                _number(t.U_factor),
            )
            for t in report.certificates
        ]
        of_paper = ("certificate", "run", "state", "verdict", "largest change / U", "U × by")
        print_rows(f"Certificates: {_shown(len(papers))}", of_paper, papers[:SHOWN])
    if report.failures:
        rows = [(f.run, f.why) for f in report.failures]
        print_rows(f"Failed: {_shown(len(rows))}", ("run", "why"), rows[:SHOWN])
    print(
        f"{report.done} results of {report.runs} runs made with {report.code_version} "
        f"({report.done_before} of them before this command): {report.unchanged} as they were to "
        f"{report.counted_in_U:g} U, "
        f"{report.first} the first of their runs, {report.failed} failed"
    )
    if out is not None:
        stdout(markup=False).print(f"report {out}")


def print_impact(impact: Impact) -> None:
    """Print runs with their results, and certificates."""
    made: dict[str, list[str]] = {}
    for result in impact.results:
        made.setdefault(result.run, []).append(f"{result.result} ({result.method})")
    runs = [
        (r.run, r.unit, str(r.recorded_on or "unknown"), ", ".join(r.documents) or str(r.station),
         ", ".join(made.get(r.run, ())))
        for r in impact.runs
    ]  # fmt: skip
    print_rows("Runs", ("run", "unit", "recorded", "named by", "results"), runs)
    papers = [
        (c.number, c.run, c.state, c.verdict, str(c.issued_on), str(c.due or "—"))
        for c in impact.certificates
    ]
    of_paper = ("certificate", "run", "state", "verdict", "issued", "due")
    print_rows("Certificates", of_paper, papers)
    if impact.undated:
        more = ", …; --json names all" if len(impact.undated) > SHOWN else ""
        print(
            f"{len(impact.undated)} more runs used it on an unknown day, possibly in this time: "
            f"{', '.join(impact.undated[:SHOWN])}{more}"
        )


def print_pruned(pruned: Pruned) -> None:
    """Print what can be deleted or was deleted, and what was not."""
    rows = [
        (
            each.run or "–",
            each.what,
            str(each.imported_at)[:10],
            f"{each.size / 1e6:.1f}",
            each.where,
        )
        for each in pruned.found
    ]
    if rows:
        print_rows("Not needed", ("run", "what", "imported", "MB", "where"), rows)
    if pruned.refused:
        left = [(each.run or each.where, each.what, each.why) for each in pruned.refused]
        print_rows("Not deleted", ("run", "what", "why"), left)
    total = sum(each.size for each in pruned.found) / 1e6
    done = "deleted" if pruned.deleted else "can go; nothing was deleted, --delete does it"
    print(f"{len(rows)} from before {pruned.before}, {total:.1f} MB: {done}")


def _shown(total: int) -> str:
    return str(total) if total <= SHOWN else f"{SHOWN} of {total}; --out writes all of them"


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.6g}"
