"""What a flow made, as artifacts on Prefect's pages; those of a unit have its serial as key.

Import this module only after `flows.on_prefect.server.connect`.
"""

import re
from collections.abc import Callable, Sequence
from functools import partial
from math import inf
from time import monotonic
from typing import TYPE_CHECKING, Any

from prefect.artifacts import (
    create_markdown_artifact,
    create_progress_artifact,
    create_table_artifact,
    update_progress_artifact,
)
from prefect.context import FlowRunContext
from prefect.settings import PREFECT_CLIENT_MAX_RETRIES, temporary_settings

from schemas.calibration import Calibration
from schemas.history import Reprocessing
from schemas.store import DueUnit
from tasks.conformity.limits import verdict_title
from tasks.stages.stage import is_of_the_server
from tasks.words import say

if TYPE_CHECKING:
    from tasks.stages.certify import Published
    from tasks.stages.explain import Explained
    from tasks.stages.review import Reviewed


PROGRESS_EVERY_S, UNANSWERED_S = 5.0, 60.0  # between two updates
MOST_ROWS = 1000  # of an artifact's table


def show(artifacts: Callable[[], None]) -> bool:
    """Writes artifacts where Prefect's server knows this run; whether it took them.

    Artifacts are for display only, and not worth waiting for a server that is down.
    """
    if FlowRunContext.get() is None:
        return False
    try:
        with temporary_settings({PREFECT_CLIENT_MAX_RETRIES: 0}):
            artifacts()
    except Exception as fault:
        if not is_of_the_server(fault):
            raise
        return False
    return True


def key_of(kind: str, unit: str) -> str:
    """The key of an artifact of a unit (its serial number): Prefect keeps its versions together."""
    plain = re.sub(r"[^a-z0-9]+", "-", unit.lower()).strip("-")
    return f"{kind}-{plain}" if plain else kind


class ProgressArtifact:
    """Shows progress as an artifact, updated rarely enough to cost nothing.

    A server that did not answer is left alone for longer: Prefect's client waits for it each time.
    """

    def __init__(self, key: str, clock: Callable[[], float] = monotonic) -> None:
        self._key, self._clock, self._next_s = key, clock, -inf
        self._artifact: Any = None

    def __call__(self, done: int, total: int) -> None:
        if done == total or self._clock() >= self._next_s:
            answers = show(partial(self._update, 100.0 * done / max(total, 1)))
            self._next_s = self._clock() + (PROGRESS_EVERY_S if answers else UNANSWERED_S)

    def _update(self, percent: float) -> None:
        if self._artifact is None:
            self._artifact = create_progress_artifact(percent, key=self._key)
        else:
            update_progress_artifact(self._artifact, percent)


def show_due(due: Sequence[DueUnit], days: int) -> None:
    """The units that are due as a Prefect artifact."""
    create_table_artifact(
        key="recalibration-due",
        table=[{"unit": d.unit, "certificate": d.certificate, "due": str(d.due)} for d in due],
        description=f"Recalibration due within {days} days",
    )


def show_changes(report: Reprocessing) -> None:
    """The largest changes and the failures, as a Prefect artifact."""
    create_table_artifact(
        key="reprocess-changes",
        table=[change.model_dump() for change in report.changed[:MOST_ROWS]],
        description=f"{report.done} results made again with {report.code_version}: "
        f"{report.unchanged} as before, {report.failed} failed, {len(report.flips)} verdicts "
        f"flipped, {len(report.certificates)} certificates touched",
    )
    create_table_artifact(
        key="reprocess-failures",
        table=[failure.model_dump() for failure in report.failures[:MOST_ROWS]],
        description=f"{report.failed} results that could not be made again",
    )


def show_certificate(published: "Published") -> None:
    """The certificate with its items, verdict, reasons and path, as Prefect artifacts."""
    certificate = published.certificate
    verdict = say(verdict_title(certificate.decision))
    reasons = "\n".join(f"- {reason}" for reason in certificate.decision.reasons)
    show_items(certificate.calibration, certificate.manifest.unit.serial)
    create_markdown_artifact(
        key=key_of("certificate", certificate.manifest.unit.serial),
        markdown=f"# {certificate.number}: {verdict} ({published.state})\n\n{reasons}\n\n"
        f"Recalibration due: {certificate.due or 'not agreed'}. PDF: `{published.pdf}`",
        description=f"Certificate {certificate.number} of run {certificate.calibration.run}",
    )


def show_discrepancy(explained: "Explained") -> None:
    """The verdict and the findings as a Prefect artifact."""
    discrepancy = explained.discrepancy
    sentences = [say(discrepancy.statement), *(say(f.statement) for f in discrepancy.findings)]
    create_markdown_artifact(
        key="discrepancy",
        markdown=f"# {discrepancy.verdict}\n\n" + "\n\n".join(sentences),
        description=f"Where model and recording {discrepancy.recording_id} differ",
    )


def show_review(reviewed: "Reviewed") -> None:
    """The findings as a Prefect artifact."""
    review = reviewed.review
    create_table_artifact(
        key="review",
        table=[
            {"effect": f.effect, "level": f.level, "carrier": f.carrier,
             "since": f.since and f.since.at, "runs": f.evidence.runs,
             "statement": say(f.statement)}
            for f in review.findings
        ],
        description=say(review.statement),
    )  # fmt: skip
    create_table_artifact(
        key="review-touched",
        table=[
            {"effect": f.effect, **each.model_dump()} for f in review.findings for each in f.touched
        ][:MOST_ROWS],
        description="Elements of certificates that these effects move, in their U",
    )


def show_items(calibration: Calibration, serial: str) -> None:
    """The values and uncertainties of a unit as a Prefect artifact."""
    rows = [
        {"item": name, "element": element, "value": value, "U": item.U[element], "unit": item.unit}
        for name, item in calibration.items.items()
        for element, value in item.value.items()
    ]
    create_table_artifact(
        key=key_of("calibration", serial),
        table=rows,
        description=f"{calibration.recording_id}, {calibration.procedure}",
    )
