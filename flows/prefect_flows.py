"""The orders as Prefect flows, with results and certificates as artifacts.

A deployment takes the order as its parameter, which Prefect validates. Import this module only
after `flows.prefect_server.connect`.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from copy import copy
from datetime import UTC, datetime, timedelta
from functools import partial, wraps
from math import inf
from time import monotonic
from typing import TYPE_CHECKING, Any

from httpx import TransportError
from prefect import Flow, flow
from prefect.artifacts import (
    create_markdown_artifact,
    create_progress_artifact,
    create_table_artifact,
    update_progress_artifact,
)
from prefect.context import FlowRunContext
from prefect.settings import PREFECT_FLOWS_HEARTBEAT_FREQUENCY, temporary_settings

from flows import run_orders
from flows.production import station_of
from schemas.base import BrokenOff, Unusable
from schemas.calibration import Calibration
from schemas.certificate_orders import (
    ProduceOrder,
)
from schemas.history import Reprocessing
from schemas.orders import (
    OrderModel,
    RemindOrder,
    ReprocessOrder,
)
from schemas.reminders import DueUnit
from tasks.conformity.limits import verdict_title
from tasks.stages import remind as reminding
from tasks.stages.stage import without_loss
from tasks.words import say

if TYPE_CHECKING:
    from tasks.stages.explain import Explained
    from tasks.stages.published import Published
    from tasks.stages.review import Reviewed

PROGRESS_EVERY_S, UNANSWERED_S = 5.0, 60.0  # between two updates
POOL = "station-"  # how the names of the stations' work pools begin
MOST_ROWS = 1000  # of an artifact's table

Show = Callable[[Any], None]


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


@flow(name="produce", flow_run_name="produce on {order.station}")
def produce(order: ProduceOrder) -> "tuple[Published, ...]":
    """Acquire a run from a station, estimate every item, decide, and draft each unit's certificate.

    Raises BrokenOff for units that were abandoned, once the others have theirs.
    """
    _check_pool(order)
    return run_orders.produce(order, lambda draft: _show(partial(_show_certificate, draft)))


def _check_pool(order: ProduceOrder) -> None:
    """Raises Unusable where the worker is one of another station's pool."""
    context = FlowRunContext.get()
    pool = context and context.flow_run and context.flow_run.work_pool_name
    station = station_of(order, run_orders.home_of(order)).station.id
    if pool and pool.startswith(POOL) and pool != f"{POOL}{station}":
        raise Unusable(
            f"the order is for station {station}, and this worker is one of pool {pool}: run "
            f"produce/{station}"
        )


@flow(name="reprocess")
def reprocess(order: ReprocessOrder) -> Reprocessing:
    """Re-process the results of a selection of runs, and report what changed."""
    report = run_orders.reprocess(order, _ProgressArtifact("reprocess"))
    _show(lambda: _show_changes(report))
    return report


@flow(name="remind")
def remind(order: RemindOrder) -> list[DueUnit]:
    """Send the reminders that are due now, and list the units due within so many days.

    Raises BrokenOff if one could not be sent; the next run tries again.
    """
    home, now = run_orders.home_of(order), datetime.now(UTC)
    faults = reminding.remind(home, now)
    due = reminding.due_units(home, now.astimezone().date() + timedelta(days=order.within_days))
    _show(lambda: _show_due(due, order.within_days))
    if faults:
        raise BrokenOff("; ".join(faults))
    return due


def _show(artifacts: Callable[[], None]) -> bool:
    """Writes artifacts where Prefect's server knows this run; whether it took them."""
    if FlowRunContext.get() is None:
        return False
    with suppress(TransportError):
        artifacts()
        return True
    return False


class _ProgressArtifact:
    """Shows progress as an artifact, updated rarely enough to cost nothing.

    A server that did not answer is left alone for longer: Prefect's client waits for it each time.
    """

    def __init__(self, key: str, clock: Callable[[], float] = monotonic) -> None:
        self._key, self._clock, self._next_s = key, clock, -inf
        self._artifact: Any = None

    def __call__(self, done: int, total: int) -> None:
        if done == total or self._clock() >= self._next_s:
            answers = _show(partial(self._update, 100.0 * done / max(total, 1)))
            self._next_s = self._clock() + (PROGRESS_EVERY_S if answers else UNANSWERED_S)

    def _update(self, percent: float) -> None:
        if self._artifact is None:
            self._artifact = create_progress_artifact(percent, key=self._key)
        else:
            update_progress_artifact(self._artifact, percent)


def _show_due(due: Sequence[DueUnit], days: int) -> None:
    """The units that are due as a Prefect artifact."""
    create_table_artifact(
        key="recalibration-due",
        table=[{"unit": d.unit, "certificate": d.certificate, "due": str(d.due)} for d in due],
        description=f"Recalibration due within {days} days",
    )


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


def _show_certificate(published: "Published") -> None:
    """The certificate with its items, verdict, reasons and path, as Prefect artifacts."""
    certificate = published.certificate
    verdict = say(verdict_title(certificate.decision), "en")
    reasons = "\n".join(f"- {reason}" for reason in certificate.decision.reasons)
    _show_items(certificate.calibration)
    create_markdown_artifact(
        key="certificate",
        markdown=f"# {certificate.number}: {verdict} ({published.state})\n\n{reasons}\n\n"
        f"Recalibration due: {certificate.due or 'not agreed'}. PDF: `{published.pdf}`",
        description=f"Certificate {certificate.number} of run {certificate.calibration.run}",
    )


def _show_discrepancy(explained: "Explained") -> None:
    """The verdict and the findings as a Prefect artifact."""
    discrepancy = explained.discrepancy
    sentences = [discrepancy.statement.en, *(f.statement.en for f in discrepancy.findings)]
    create_markdown_artifact(
        key="discrepancy",
        markdown=f"# {discrepancy.verdict}\n\n" + "\n\n".join(sentences),
        description=f"Where model and recording {discrepancy.recording_id} differ",
    )


def _show_review(reviewed: "Reviewed") -> None:
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


def _ordered(
    function: str, run_name: str | None, show: Show = lambda _: None, name: str = ""
) -> Any:
    """The flow that carries out an order by the function of that name in `run_orders`.

    show: writes the artifacts of the answer, where the server takes them. name: of the flow, where
    it is another.
    """

    # all but the module: the flow is one of this file
    @wraps(getattr(run_orders, function), assigned=("__name__", "__qualname__", "__doc__"))
    def carried_out(order: OrderModel) -> Any:
        answer = getattr(run_orders, function)(order)
        _show(lambda: show(answer))
        return answer

    return flow(name=name or function, flow_run_name=run_name)(carried_out)


acquire = _ordered("acquire", "acquire on {order.station}")
calibrate = _ordered("calibrate", "calibrate {order.run}", _show_items)
explain = _ordered("explain", "explain {order.run}", _show_discrepancy)
review = _ordered("review", None, _show_review)
next_recording = _ordered("next_recording", "next recording of {order.runs}", name="next")
simulate = _ordered("simulate", "simulate {order.run}")
apply = _ordered("apply", "apply {order.calibration} to {order.run}")
certify = _ordered("certify", "certify {order.run}", _show_certificate)
check = _ordered("check", "check {order.certificate}")
issue = _ordered("issue", "issue {order.certificate}", _show_certificate)
amend = _ordered("amend", "amend {order.certificate}", _show_certificate)
withdraw = _ordered("withdraw", "withdraw {order.certificate}")
