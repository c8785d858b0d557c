"""Prints a calibration, a certificate, a discrepancy and the history of a run."""

import csv
import json
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from pydantic import TypeAdapter, ValidationError
from rich.console import Console
from rich.table import Table
from rich.text import Text

from flows.terminal import print_json, print_rows, stdout
from schemas.base import Unusable, first_fault
from schemas.calibration import Calibration, Information, Item
from schemas.certificate import AsFound
from schemas.discrepancy import Discrepancy, ReportedFinding, Review, ReviewFinding, Verdict
from schemas.history import Impact, Plan, Pruned, Reprocessing
from schemas.recording import LogEntry
from schemas.text import Validity, text_of, texts_of
from schemas.tolerance import Verdict as ToleranceVerdict
from storage.catalogue import audit_trail, certificates, results, runs
from storage.catalogue.audit_trail import TrailEntry
from storage.home import Home, home
from tasks.certificate.statements import once_for_all
from tasks.specifications.estimate import item_title
from tasks.words import known, message, say
from tasks.words.numbers import USUAL_K, chi2, column, percent, quantities, unit_text

if TYPE_CHECKING:
    from schemas.procedure import Procedure
    from schemas.text import Validity
    from storage.catalogue.runs import Run
    from tasks.stages.acquire import AcquiredRuns
    from tasks.stages.certify import Published
    from tasks.stages.explain import Explained
    from tasks.stages.review import Reviewed
    from tasks.station.acquisition import Acquired


# Prints a calibration.


def print_calibration(calibration: Calibration) -> None:
    """Print a table of every item, then what is unavailable and what the reader must know."""
    console = stdout()
    table = _results_table(f"{calibration.recording_id} · {calibration.procedure}", "item")
    for name, item in calibration.items.items():
        _add_item(table, say(item_title(name)), item)
    console.print(table)
    console.print(say(message(f"flows-run.{calibration.validity.verdict}")), style="bold")
    _print_information(console, calibration)
    for name in calibration.unavailable:
        console.print(f"[yellow]{say(message('flows-not-determined'))}[/] ", end="")
        why = say(calibration.why_unavailable(name) or "")
        console.print(f"{say(item_title(name))}: {why}", markup=False)
    for first, sentence in once_for_all(calibration.remarks):
        mark = "[red]![/]" if first.blocks_pass else "[dim]·[/]"
        console.print(f"{mark} ", end="")
        console.print(say(sentence), markup=False)


def _print_information(console: Console, calibration: Calibration) -> None:
    """Print a second table with the additional information, and its sentences."""
    if not calibration.information:
        return
    table = _results_table(say(message("flows-for-information")), "quantity")
    for shown in calibration.information.values():
        if any(value is not None for value in shown.value.values()):
            _add_item(table, say(text_of(shown, "title") or ""), shown)
    console.print(table)
    for shown in calibration.information.values():
        console.print(f"[dim]· {say(text_of(shown, 'title') or '')}:[/] ", end="")
        console.print(say(shown), markup=False)


def _results_table(title: str, of: str) -> Table:
    table = Table(title=Text(title))
    for name, justify in ((of, "left"), ("", "left"), ("value", "right"), ("U", "right"),
                          ("k", "right"), ("unit", "left")):  # fmt: skip
        table.add_column(column_title(name), justify=justify)  # type: ignore[arg-type]
    return table


def column_title(name: str) -> str:
    """The heading of a column; a symbol stays as it is."""
    return say(message(f"flows-column.{name}")) if known(f"flows-column.{name}") else name


def _add_item(table: Table, name: str, item: Item | Information) -> None:
    U = item.U or {}
    texts = column(list(item.value.values()), [U.get(element) for element in item.value], item.k)
    power = f"×10^{texts.exponent} " if texts.exponent else ""
    rows = zip(item.value, texts.values, texts.uncertainties, strict=True)
    for row, (element, value, expanded) in enumerate(rows):
        table.add_row(
            name if row == 0 else "",
            Text(element),
            value or "–",
            expanded or "–",
            f"{item.k:g}",
            power + unit_text(item.unit),
            end_section=row == len(item.value) - 1,
        )


def summary(validity: Validity) -> dict[str, Any]:
    """The validity as in JSON."""
    return {"verdict": validity.verdict, "reasons": list(validity.reasons)}


def lines(validity: Validity) -> list[str]:
    """The validity, and a line for each reason."""
    return [
        say(message(f"flows-run.{validity.verdict}")),
        *(f"  {say(reason)}" for reason in texts_of(validity, "reasons")),
    ]


# Prints a certificate.

TOLERANCE_COLOURS: dict[ToleranceVerdict, str] = {
    "pass": "green",
    "fail": "red",
    "inconclusive": "yellow",
}


def print_certificate(published: "Published", as_json: bool) -> None:
    """Print a certificate for a person, or as one JSON document."""
    if as_json:
        print_json(_document(published))
    else:
        print_verdict(published)


def print_verdict(published: "Published") -> None:
    """Print the verdict, each failed, open or conditional item, the due date and the files.

    For an amendment, also what it changes; for a draft, what it still has to state, and the
    commands that come next.
    """
    from tasks.conformity.limits import (
        conditional,
        verdict_title,  # late: a calibration prints without it
    )

    certificate, console = published.certificate, stdout()
    decision = certificate.decision
    verdict = f"[bold {TOLERANCE_COLOURS[decision.verdict]}]{say(verdict_title(decision))}[/]"
    console.print(f"{certificate.number}: {verdict} ({published.state})")
    for reason in (
        *map(say, texts_of(decision, "reasons")),
        *(say(condition) for condition in conditional(decision)),
    ):
        console.print(f"  {reason}", markup=False)
    for changed in certificate.replaces.changes if certificate.replaces else ():
        console.print(
            f"  {say(changed.what)}: {say(changed.before)} → {say(changed.after)}", markup=False
        )
    for sentence in published.missing:
        console.print(f"  {say(sentence)}", markup=False)
    if published.due:
        console.print(say(message("flows-due", day=f"{published.due}")))
    for path in (published.pdf, published.dcc, published.record, published.evidence):
        if path:
            print(path)
    if known(following := f"flows-next.{published.state}"):
        print(say(message(following, number=certificate.number)))


def _document(published: "Published") -> dict[str, Any]:
    certificate = published.certificate
    decision = certificate.decision
    return {
        "format": "mimu-certificate/1",
        "number": certificate.number,
        "verdict": decision.verdict,
        "state": published.state,
        "pdf": str(published.pdf),
        "dcc": str(published.dcc) if published.dcc else None,
        "record": str(published.record),
        "evidence": str(published.evidence) if published.evidence else None,
        "run": certificate.calibration.run,
        "as_found": _as_found(certificate.as_found),
        "replaces": certificate.replaces.model_dump(mode="json") if certificate.replaces else None,
        "steps": [step.model_dump(mode="json") for step in certificate.steps],
        "due": published.due.isoformat() if published.due else None,
        "reasons": list(decision.reasons),
        "missing": [say(sentence) for sentence in published.missing],
        "conditional": decision.marginal,
        "decisions": [made.model_dump(mode="json") for made in decision.limits],
    }


def _as_found(found: AsFound | None) -> dict[str, Any] | None:
    if found is None:
        return None
    return {"run": found.calibration.run, "verdict": found.decision.verdict}


def print_trail(form: str) -> None:
    """Print every entry in the order of writing."""
    entries = audit_trail.entries(home())
    if form == "json":
        print_json({"format": "mimu-trail/1", "entries": [_fields(entry) for entry in entries]})
    elif form == "jsonl":
        for entry in entries:
            print(json.dumps(_fields(entry), ensure_ascii=False))
    elif form == "csv":
        writer = csv.writer(sys.stdout, lineterminator="\n")
        writer.writerow(TrailEntry.model_fields)
        writer.writerows(entry.model_dump(mode="json").values() for entry in entries)
    elif form == "table":
        rows = [
            (str(e.number), f"{e.at:%F %T}", e.person, e.action, e.subject, _reason(e))
            for e in entries
        ]
        print_rows("Trail", ("entry", "UTC", "person", "action", "subject", "reason"), rows)
    else:
        raise Unusable(f"--as {form}: choose one of table, csv, jsonl")


def _fields(entry: TrailEntry) -> dict[str, object]:
    return entry.model_dump(mode="json") | {"details": json.loads(entry.details)}


def _reason(entry: TrailEntry) -> str:
    return str(json.loads(entry.details).get("reason") or "")


# Prints a discrepancy, and a review.

MISMATCH_COLOURS: dict[Verdict, str] = {
    "no_mismatch": "green", "explained": "green", "partly_explained": "yellow",
    "unexplained": "red",
}  # fmt: skip
COLUMNS = ("missing", "share", "channels", "parameter", "value", "U (k = 2)", "unit")
REVIEW_COLUMNS = ("effect", "carrier", "since", "parameter", "value", "U (k = 2)", "unit", "runs")
NUMERIC = ("share", "value", "U (k = 2)", "runs")
MAX_CONSEQUENCES = 8  # rows of a finding; the report has them all


def print_discrepancy(explained: "Explained") -> None:
    """Print the verdict, the findings with their parameters, their consequences, and the files."""
    discrepancy, console = explained.discrepancy, stdout()
    verdict = say(message(f"report-{discrepancy.verdict}"))
    console.print(f"[bold {MISMATCH_COLOURS[discrepancy.verdict]}]{verdict}[/] ", end="")
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
    from tasks.explain.correction.consequences import moved_by
    from tasks.explain.report import statements

    console.print(say(finding.statement), markup=False)
    listed = sorted(finding.consequences, key=moved_by, reverse=True)
    for moved in listed[:MAX_CONSEQUENCES]:
        made = statements.before_and_after(moved)
        before, after = (made.text(k) if made.values[k] else "–" for k in range(2))
        element = say(statements.element_title(moved.item, moved.element))
        line = f"  {element}: {before} → {after}"
        times = statements.shift_text(moved)
        console.print(f"{line}, {times} U" if times else line, markup=False)
    if len(listed) > MAX_CONSEQUENCES:
        left = len(listed) - MAX_CONSEQUENCES
        more = message("flows-more-elements", count=left)
        console.print(f"  {say(more)}", style="dim")
    for change in finding.verdict_changes:
        item, verdicts = statements.element_title(change.item, ""), statements.change_title(change)
        sentence = say(message("flows-verdict-of", item=item, change=verdicts))
        console.print(f"  {sentence}", style="bold", markup=False)


def print_review(reviewed: "Reviewed") -> None:
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


# Prints a re-processing report, an impact report, and what the store can do without.

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


# Prints one run.


def show_run(reference: str, as_json: bool) -> None:
    """Print a run: unit, station, validity, segments, newest results, certificates."""
    from tasks.stages.estimate import validity_of
    from tasks.stages.import_recording import run_of

    run = run_of(reference, home())
    manifest = runs.manifest(run, home())
    kept, validity = results.of_run(run, home()), validity_of(run, home())
    entries = certificates.of_run(run, home())
    if as_json:
        print_json(
            {
                "format": "mimu-run/1",
                "run": run.model_dump(mode="json"),
                "validity": summary(validity),
                "manifest": manifest.model_dump(mode="json"),
                "results": [result.model_dump(mode="json") for result in kept],
                "certificates": [entry.model_dump(mode="json") for entry in entries],
            }
        )
        return
    unit, station = manifest.unit, manifest.station
    console = stdout(markup=False)
    console.print(f"{run.id} {run.recording_id} ({run.standard})", style="bold")
    console.print(f"unit     {unit.manufacturer} {unit.model} {unit.serial}")
    console.print(f"station  {station.id}")
    console.print(
        f"length   {run.seconds:.1f} s, {run.rows} rows; imported {run.imported_at:%F %R}"
    )
    for line in lines(validity):
        console.print(line)
    if manifest.segments:
        print_rows(
            "Segments",
            ("name", "kind", "from s", "to s"),
            [(s.name, s.kind, f"{s.t_start:.2f}", f"{s.t_end:.2f}") for s in manifest.segments],
        )
    if kept:
        print_calibration(kept[-1].calibration)
    for entry in entries:
        console.print(f"certificate {entry.number}: {entry.verdict} ({entry.state}), {entry.pdf}")


def show_log(reference: str, as_json: bool) -> None:
    """Print the log of a run.

    Raises Unusable if its manifest has no log, or an invalid one.
    """
    from tasks.stages.import_recording import run_of

    run = run_of(reference, home())
    kept = (runs.manifest(run, home()).model_extra or {}).get("log")
    if kept is None:
        raise Unusable(f"run {run.id} has no log: no acquisition of this program recorded it")
    try:
        log = TypeAdapter(tuple[LogEntry, ...]).validate_python(kept)
    except ValidationError as error:
        raise Unusable(f"the log of run {run.id} is not understood: {first_fault(error)}") from None
    if as_json:
        entries = [entry.model_dump(mode="json") for entry in log]
        print_json({"format": "mimu-run-log/1", "run": run.id, "log": entries})
        return
    rows = [(f"{e.at:%F %T}", f"{e.t:.2f}", e.state.replace("_", " "), say(e)) for e in log]
    print_rows(f"Log of run {run.id}", ("UTC", "at s", "state", "cause"), rows)


def print_dry_run(procedure: "Procedure", as_json: bool) -> None:
    """Print every segment of a procedure, with its start and its motion; nothing is moved."""
    from tasks.station.plan import plan

    begins_s, rows = procedure.warm_up_s, []
    for segment in plan(procedure):
        rows.append(
            {
                "segment": segment.name,
                "begins_s": round(begins_s, 1),
                "takes_s": round(segment.planned_s, 1),
                "angles_deg": segment.angles_deg,
                "rate_deg_s": segment.rate_deg_s,
                "refix": segment.refix.name if segment.refix else None,
            }
        )
        begins_s += segment.planned_s
    if as_json:
        print_json({"format": "mimu-dry-run/1", "station_s": round(begins_s, 1), "segments": rows})
        return
    print_rows(
        f"{procedure.title}: {begins_s:.0f} s", tuple(rows[0]), [_planned(row) for row in rows]
    )


def _planned(row: dict[str, Any]) -> tuple[str, ...]:
    angles = " ".join(f"{angle:g}" for angle in row["angles_deg"])
    return tuple(
        str("" if value is None else value) for value in (row | {"angles_deg": angles}).values()
    )


def print_acquired(acquired: "AcquiredRuns", home: Home, as_json: bool) -> bool:
    """Print the runs and their validity; returns whether none is invalid."""
    from tasks.stages.estimate import validity_of

    judged = [(run, made, validity_of(run, home)) for run, made in acquired.kept]
    if as_json:
        first, *others = (_as_data(*each) for each in judged)
        several = {"neighbours": others, "given_up": list(map(str, acquired.given_up))}
        is_alone = not others and not acquired.given_up
        print_json({"format": "mimu-acquire/1"} | first | ({} if is_alone else several))
    else:
        for run, made, validity in judged:
            print(run.id)
            for sentence in (*(say(remark) for remark in made.warnings), *lines(validity)):
                print(sentence, file=sys.stderr)
    return all(validity.verdict != "invalid" for *_, validity in judged)


def _as_data(run: "Run", made: "Acquired", validity: "Validity") -> dict[str, Any]:
    return {
        "run": run.id,
        "recording_id": run.recording_id,
        "lost_samples": made.lost_samples,
        "bad_frames": made.bad_frames,
        "warnings": [say(remark) for remark in made.warnings],
        "validity": summary(validity),
    }
