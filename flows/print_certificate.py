"""Prints a certificate."""

import csv
import json
import sys
from typing import TYPE_CHECKING, Any

from flows.printing import print_json, print_rows, stdout
from schemas.base import Unusable
from schemas.certificate import AsFound
from schemas.decision import Verdict as ToleranceVerdict
from schemas.text import texts_of
from storage.catalogue import trail
from storage.catalogue.trail import Entry
from storage.home import home
from tasks.words import known, message, say

if TYPE_CHECKING:
    from tasks.stages.published import Published

COLOURS: dict[ToleranceVerdict, str] = {"pass": "green", "fail": "red", "inconclusive": "yellow"}


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
    from tasks.conformity.limits import verdict_title  # late: a calibration prints without it
    from tasks.conformity.reasons import conditional

    certificate, console = published.certificate, stdout()
    decision = certificate.decision
    verdict = f"[bold {COLOURS[decision.verdict]}]{say(verdict_title(decision))}[/]"
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
    entries = trail.entries(home())
    if form == "json":
        print_json({"format": "mimu-trail/1", "entries": [_fields(entry) for entry in entries]})
    elif form == "jsonl":
        for entry in entries:
            print(json.dumps(_fields(entry), ensure_ascii=False))
    elif form == "csv":
        writer = csv.writer(sys.stdout, lineterminator="\n")
        writer.writerow(Entry.model_fields)
        writer.writerows(entry.model_dump(mode="json").values() for entry in entries)
    elif form == "table":
        rows = [
            (str(e.number), f"{e.at:%F %T}", e.person, e.action, e.subject, _reason(e))
            for e in entries
        ]
        print_rows("Trail", ("entry", "UTC", "person", "action", "subject", "reason"), rows)
    else:
        raise Unusable(f"--as {form}: choose one of table, csv, jsonl")


def _fields(entry: Entry) -> dict[str, object]:
    return entry.model_dump(mode="json") | {"details": json.loads(entry.details)}


def _reason(entry: Entry) -> str:
    return str(json.loads(entry.details).get("reason") or "")
