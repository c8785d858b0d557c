"""The orders as Prefect flows, with results and certificates as artifacts.

A deployment takes the order as its parameter, which Prefect validates. Import this module only
after `flows.prefect_server.connect`.
"""

from collections.abc import Callable
from contextlib import suppress
from copy import copy
from datetime import UTC, datetime, timedelta
from time import monotonic
from typing import Any

from httpx import TransportError
from prefect import Flow, flow
from prefect.artifacts import (
    create_markdown_artifact,
    create_progress_artifact,
    create_table_artifact,
    update_progress_artifact,
)
from prefect.settings import PREFECT_FLOWS_HEARTBEAT_FREQUENCY, temporary_settings

from flows import run_orders
from schemas.base import BrokenOff
from schemas.calibration import Calibration
from schemas.certificate_orders import (
    AmendOrder,
    CertifyOrder,
    CheckOrder,
    IssueOrder,
    ProduceOrder,
    WithdrawOrder,
)
from schemas.history import Reprocessing
from schemas.next_recording import NextRecording
from schemas.orders import (
    AcquireOrder,
    ApplyOrder,
    CalibrateOrder,
    ExplainOrder,
    NextOrder,
    OrderModel,
    RemindOrder,
    ReprocessOrder,
    ReviewOrder,
    SimulateOrder,
)
from schemas.reminders import DueUnit
from tasks.conformity.limits import verdict_title
from tasks.stages import remind as reminding
from tasks.stages.acquire import AcquiredRuns
from tasks.stages.certificate_inputs import read_inputs
from tasks.stages.correct import Corrected
from tasks.stages.explain import Explained
from tasks.stages.published import Published
from tasks.stages.review import Reviewed
from tasks.stages.simulate import Simulated
from tasks.stages.stage import without_loss
from tasks.words import say

PROGRESS_EVERY_S = 5.0
MOST_ROWS = 1000  # of an artifact's table


def run_now(named: Flow[..., Any], order: OrderModel) -> Any:
    """Run a flow in this process, from its main thread, and return its result.

    Without its heartbeat, whose thread makes every synchronous flow run wait for a second (prefect
    3.8).
    """

    def with_body(body: Callable[..., Any]) -> Flow[..., Any]:
        flow_ = copy(named)
        flow_.fn = body
        return flow_

    with temporary_settings({PREFECT_FLOWS_HEARTBEAT_FREQUENCY: None}):
        return without_loss(named.fn, with_body)(order)


@flow(name="acquire", flow_run_name="acquire on {order.station}")
def acquire(order: AcquireOrder) -> AcquiredRuns:
    """Acquire a run of each unit on the station of a station file."""
    return run_orders.acquire(order)


@flow(name="produce", flow_run_name="produce on {order.station}")
def produce(order: ProduceOrder) -> tuple[Published, ...]:
    """Acquire a run from a station, estimate every item, decide, and draft each unit's certificate.

    Raises BrokenOff for units that were abandoned, once the others have theirs.
    """
    read_inputs(order)  # bad files are refused before it turns
    acquired = acquire(order)
    drafts = tuple(certify(order.certify(run.id)) for run, _ in acquired.kept)
    if acquired.given_up:
        raise BrokenOff("; ".join(acquired.given_up))
    return drafts


@flow(name="calibrate", flow_run_name="calibrate {order.run}")
def calibrate(order: CalibrateOrder) -> Calibration:
    """Estimate every item that a run (an id, or a path imported on the fly) allows."""
    calibration = run_orders.calibrate(order)
    with suppress(TransportError):
        _show_items(calibration)
    return calibration


@flow(name="explain", flow_run_name="explain {order.run}")
def explain(order: ExplainOrder) -> Explained:
    """Find where model and run differ, which physics was left out, and how much it matters."""
    explained = run_orders.explain(order)
    with suppress(TransportError):
        _show_discrepancy(explained)
    return explained


@flow(name="review")
def review(order: ReviewOrder) -> Reviewed:
    """Find what many runs show together, what carries it and since when."""
    reviewed = run_orders.review(order)
    with suppress(TransportError):
        _show_review(reviewed)
    return reviewed


@flow(name="next", flow_run_name="next recording of {order.runs}")
def next_recording(order: NextOrder) -> NextRecording:
    """Propose the recording that settles what the explanations of some runs left open."""
    return run_orders.next_recording(order)


@flow(name="simulate", flow_run_name="simulate {order.run}")
def simulate(order: SimulateOrder) -> Simulated:
    """Simulate the readings of a calibrated unit for the motion of a run."""
    return run_orders.simulate(order)


@flow(name="apply", flow_run_name="apply {order.calibration} to {order.run}")
def apply(order: ApplyOrder) -> Corrected:
    """Write a run corrected for its unit's errors."""
    return run_orders.apply(order)


@flow(name="certify", flow_run_name="certify {order.run}")
def certify(order: CertifyOrder) -> Published:
    """Estimate, decide and draft the certificate of a run."""
    return _shown(run_orders.certify(order))


@flow(name="check", flow_run_name="check {order.certificate}")
def check(order: CheckOrder) -> Published:
    """Record that a person checked the draft of a certificate."""
    return run_orders.check(order)


@flow(name="issue", flow_run_name="issue {order.certificate}")
def issue(order: IssueOrder) -> Published:
    """Issue a checked certificate under the laboratory's next number."""
    return _shown(run_orders.issue(order))


@flow(name="amend", flow_run_name="amend {order.certificate}")
def amend(order: AmendOrder) -> Published:
    """Draft a certificate that replaces an issued one."""
    return _shown(run_orders.amend(order))


@flow(name="withdraw", flow_run_name="withdraw {order.certificate}")
def withdraw(order: WithdrawOrder) -> Published:
    """Withdraw an issued certificate."""
    return run_orders.withdraw(order)


@flow(name="reprocess")
def reprocess(order: ReprocessOrder) -> Reprocessing:
    """Re-process the results of a selection of runs, and report what changed."""
    report = run_orders.reprocess(order, _progress_artifact("reprocess"))
    with suppress(TransportError):
        _show_changes(report)
    return report


@flow(name="remind")
def remind(order: RemindOrder) -> list[DueUnit]:
    """Send the reminders that are due now, and list the units due within so many days.

    Raises BrokenOff if one could not be sent; the next run tries again.
    """
    home, now = run_orders.home_of(order), datetime.now(UTC)
    faults = reminding.remind(home, now)
    due = reminding.due_units(home, now.astimezone().date() + timedelta(days=order.within_days))
    create_table_artifact(
        key="recalibration-due",
        table=[{"unit": d.unit, "certificate": d.certificate, "due": str(d.due)} for d in due],
        description=f"Recalibration due within {order.within_days} days",
    )
    if faults:
        raise BrokenOff("; ".join(faults))
    return due


def _progress_artifact(key: str) -> Callable[[int, int], None]:
    """Shows progress as an artifact, updated rarely enough to cost nothing."""
    shown: list[tuple[Any, float]] = []

    def show(done: int, total: int) -> None:
        now, percent = monotonic(), 100.0 * done / max(total, 1)
        with suppress(TransportError):
            if not shown:
                shown.append((create_progress_artifact(percent, key=key), now))
            elif now - shown[-1][1] > PROGRESS_EVERY_S or done == total:
                update_progress_artifact(shown[-1][0], percent)
                shown.append((shown[-1][0], now))

    return show


def _show_changes(report: Reprocessing) -> None:
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


def _shown(published: Published) -> Published:
    """The certificate with its items, verdict, reasons and path, as Prefect artifacts."""
    certificate = published.certificate
    verdict = say(verdict_title(certificate.decision), "en")
    reasons = "\n".join(f"- {reason}" for reason in certificate.decision.reasons)
    with suppress(TransportError):
        _show_items(certificate.calibration)
        create_markdown_artifact(
            key="certificate",
            markdown=f"# {certificate.number}: {verdict} ({published.state})\n\n{reasons}\n\n"
            f"Recalibration due: {certificate.due or 'not agreed'}. PDF: `{published.pdf}`",
            description=f"Certificate {certificate.number} of run {certificate.calibration.run}",
        )
    return published


def _show_discrepancy(explained: Explained) -> None:
    """The verdict and the findings as a Prefect artifact."""
    discrepancy = explained.discrepancy
    sentences = [discrepancy.statement.en, *(f.statement.en for f in discrepancy.findings)]
    create_markdown_artifact(
        key="discrepancy",
        markdown=f"# {discrepancy.verdict}\n\n" + "\n\n".join(sentences),
        description=f"Where model and recording {discrepancy.recording_id} differ",
    )


def _show_review(reviewed: Reviewed) -> None:
    """The findings as a Prefect artifact."""
    review = reviewed.review
    create_table_artifact(
        key="review",
        table=[
            {"effect": f.effect, "level": f.level, "carrier": f.carrier,
             "since": f.since and f.since.at, "runs": f.evidence.runs, "statement": f.statement.en}
            for f in review.findings
        ],
        description=review.statement.en,
    )  # fmt: skip
    create_table_artifact(
        key="review-touched",
        table=[
            {"effect": f.effect, **each.model_dump()} for f in review.findings for each in f.touched
        ][:MOST_ROWS],
        description="Elements of certificates that these effects move, in their U",
    )


def _show_items(calibration: Calibration) -> None:
    """The values and uncertainties as a Prefect artifact."""
    rows = [
        {"item": name, "element": element, "value": value, "U": item.U[element], "unit": item.unit}
        for name, item in calibration.items.items()
        for element, value in item.value.items()
    ]
    create_table_artifact(
        key="calibration-items",
        table=rows,
        description=f"{calibration.recording_id}, {calibration.procedure}",
    )
