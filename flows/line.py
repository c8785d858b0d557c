"""The orders as Prefect flows, whose results and certificates are artifacts.

Import this module only after `flows.server.prepare`.
"""

from datetime import date
from typing import Any

from prefect import Flow, flow
from prefect.artifacts import create_markdown_artifact, create_table_artifact
from prefect.settings import PREFECT_FLOWS_HEARTBEAT_FREQUENCY, temporary_settings

from flows import embedded, orders
from flows.papers import read_papers
from flows.server import server_named
from schemas.calibration import Calibration, Method
from storage.catalogue.certificates import Due
from storage.catalogue.runs import Run
from tasks.certificate.names import verdict_words
from tasks.stages import as_tasks
from tasks.stages.certify import Issued
from tasks.stages.explain import Explained
from tasks.stages.remind import due_within
from tasks.stages.simulate import Simulated
from tasks.station.sequence import Acquired


def run_now(named: Flow[..., Any], **parameters: Any) -> Any:
    """Run a flow in this process, from its main thread, and return what it returns.

    Without its heartbeat, whose thread makes every synchronous flow run wait for a second
    (prefect 3.8).
    """
    if not server_named():
        embedded.start(orders.place(None).prefect)
    with temporary_settings({PREFECT_FLOWS_HEARTBEAT_FREQUENCY: None}):
        return named(**parameters)


@flow(name="acquire", flow_run_name="acquire on {station}")
def acquire(
    station: str,
    procedure: str = "jjf2003",
    home_folder: str | None = None,
    attended: bool = True,
) -> tuple[Run, Acquired]:
    """Acquire a run from the station of a station file.

    attended: whether a person at the terminal, if there is one, may be asked.
    """
    return orders.acquire(as_tasks, station, procedure, home_folder, attended)


@flow(name="produce", flow_run_name="produce on {station}")
def produce(
    station: str,
    procedure: str = "jjf2003",
    tolerance: str | None = None,
    laboratory: str | None = None,
    order: str | None = None,
    home_folder: str | None = None,
) -> Issued:
    """Acquire a run from a station, estimate every item, decide, publish the certificate."""
    read_papers(tolerance, laboratory, order, None)  # bad papers are refused before it turns
    run, _ = acquire(station, procedure, home_folder)
    return certify(
        run.id, tolerance=tolerance, laboratory=laboratory, order=order, home_folder=home_folder
    )


@flow(name="calibrate", flow_run_name="calibrate {reference}")
def calibrate(
    reference: str,
    method: Method | None = None,
    uncertainty: str = "gum",
    terms: str | None = None,
    home_folder: str | None = None,
) -> Calibration:
    """Estimate every item that a run (an id, or a path taken in on the fly) allows."""
    calibration = orders.calibrate(as_tasks, reference, method, uncertainty, terms, home_folder)
    _show_items(calibration)
    return calibration


@flow(name="explain", flow_run_name="explain {reference}")
def explain(
    reference: str,
    out: str | None = None,
    calibration: str | None = None,
    simulated: str | None = None,
    home_folder: str | None = None,
) -> Explained:
    """Say where model and run differ, which physics was left out, and what it matters."""
    explained = orders.explain(as_tasks, reference, out, calibration, simulated, home_folder)
    _show_discrepancy(explained)
    return explained


@flow(name="simulate", flow_run_name="simulate {reference}")
def simulate(
    reference: str,
    out: str,
    calibration: str | None = None,
    home_folder: str | None = None,
) -> Simulated:
    """Write what a unit with a calibration would have read on a run's motion."""
    return orders.simulate(as_tasks, reference, out, calibration, home_folder)


@flow(name="certify", flow_run_name="certify {reference}")
def certify(
    reference: str,
    method: Method | None = None,
    uncertainty: str = "gum",
    tolerance: str | None = None,
    laboratory: str | None = None,
    order: str | None = None,
    calibrated_on: date | None = None,
    budget: bool = False,
    terms: str | None = None,
    home_folder: str | None = None,
) -> Issued:
    """Estimate, decide and publish the certificate of a run."""
    issued = orders.certify(
        as_tasks, reference, method, uncertainty, tolerance, laboratory, order, calibrated_on,
        budget, terms, home_folder,
    )  # fmt: skip
    _show_items(issued.certificate.calibration)
    _show_certificate(issued)
    return issued


@flow(name="remind")
def remind(within_days: int = 30, home_folder: str | None = None) -> list[Due]:
    """List the units whose recalibration is due within so many days."""
    due = due_within(orders.place(home_folder), within_days)
    create_table_artifact(
        key="recalibration-due",
        table=[{"unit": d.unit, "certificate": d.certificate, "due": str(d.due)} for d in due],
        description=f"Recalibration due within {within_days} days",
    )
    return due


def _show_certificate(issued: Issued) -> None:
    """The verdict, why, and where the certificate lies, as a Prefect artifact."""
    certificate = issued.certificate
    verdict = verdict_words(certificate.decision)[1]
    reasons = "\n".join(f"- {reason}" for reason in certificate.decision.reasons)
    create_markdown_artifact(
        key="certificate",
        markdown=f"# {certificate.number}: {verdict}\n\n{reasons}\n\n"
        f"Recalibration due {certificate.due}. PDF: `{issued.pdf}`",
        description=f"Certificate {certificate.number} of run {certificate.calibration.run}",
    )


def _show_discrepancy(explained: Explained) -> None:
    """The verdict and what was found as a Prefect artifact."""
    discrepancy = explained.discrepancy
    said = (discrepancy.statement, *(found.statement for found in discrepancy.findings))
    create_markdown_artifact(
        key="discrepancy",
        markdown=f"# {discrepancy.verdict}\n\n" + "\n\n".join(each.en for each in said),
        description=f"Where model and recording {discrepancy.recording_id} differ",
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
