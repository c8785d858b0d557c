"""Prints a certificate."""

from typing import TYPE_CHECKING, Any

from flows.printing import print_json, stdout
from schemas.certificate import AsFound
from schemas.decision import Verdict
from tasks.words import say

if TYPE_CHECKING:
    from tasks.stages.published import Published

COLOURS: dict[Verdict, str] = {"pass": "green", "fail": "red", "inconclusive": "yellow"}
NEXT = {
    "draft": "next: mimucal check {number} --by NAME, then mimucal issue {number} --by NAME",
    "checked": "next: mimucal issue {number} --by NAME",
}


def print_certificate(published: "Published", as_json: bool) -> None:
    """Print a certificate for a person, or as one JSON document."""
    if as_json:
        print_json(_document(published))
    else:
        print_verdict(published)


def print_verdict(published: "Published") -> None:
    """Print the verdict, each failed, open or conditional item, the due date and the files.

    For a draft, also the commands that come next.
    """
    from tasks.conformity.limits import verdict_title  # late: a calibration prints without it
    from tasks.conformity.reasons import conditional

    certificate, console = published.certificate, stdout()
    decision = certificate.decision
    verdict = f"[bold {COLOURS[decision.verdict]}]{say(verdict_title(decision), 'en')}[/]"
    console.print(f"{certificate.number}: {verdict} ({published.state})")
    for reason in (
        *decision.reasons,
        *(say(condition, "en") for condition in conditional(decision)),
    ):
        console.print(f"  {reason}", markup=False)
    if published.due:
        console.print(f"recalibration due {published.due}")
    for path in (published.pdf, published.dcc, published.record):
        if path:
            print(path)
    if published.state in NEXT:
        print(NEXT[published.state].format(number=certificate.number))


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
        "run": certificate.calibration.run,
        "as_found": _as_found(certificate.as_found),
        "replaces": certificate.replaces.model_dump(mode="json") if certificate.replaces else None,
        "steps": [step.model_dump(mode="json") for step in certificate.steps],
        "due": published.due.isoformat() if published.due else None,
        "reasons": list(decision.reasons),
        "conditional": decision.marginal,
        "decisions": [made.model_dump(mode="json") for made in decision.limits],
    }


def _as_found(found: AsFound | None) -> dict[str, Any] | None:
    if found is None:
        return None
    return {"run": found.calibration.run, "verdict": found.decision.verdict}
