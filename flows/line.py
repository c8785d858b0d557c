"""The flows of the line. Each takes plain values, so that a schedule can order it too.

Import this module only after `flows.orders.prepare`.
"""

from pathlib import Path
from typing import Any

from prefect import Flow, flow
from prefect.artifacts import create_markdown_artifact, create_table_artifact
from prefect.settings import PREFECT_FLOWS_HEARTBEAT_FREQUENCY, temporary_settings

from flows.papers import Papers, read_papers, read_procedure
from flows.progress import acquisition_progress
from schemas.calibration import Calibration, Method
from storage import settings, store
from storage.home import Home, home
from storage.store import Due
from tasks.stages import as_tasks
from tasks.stages.certify import Issued
from tasks.stages.remind import due_within
from tasks.station.sequence import Acquired


def run_now(named: Flow[..., Any], **parameters: Any) -> Any:
    """Run a flow in this process and return what it returns.

    Without its heartbeat, whose thread makes every synchronous flow run wait for a second
    (prefect 3.8).
    """
    with temporary_settings({PREFECT_FLOWS_HEARTBEAT_FREQUENCY: None}):
        return named(**parameters)


def _home(folder: str | None) -> Home:
    return Home(Path(folder)) if folder else home()


@flow(name="acquire", flow_run_name="acquire on {station}")
def acquire(
    station: str, procedure: str = "jjf2003", home_folder: str | None = None
) -> tuple[store.Run, Acquired]:
    """Acquire a run from the station of a station file."""
    stand = settings.read_station(Path(station))
    steps = read_procedure(procedure)
    with acquisition_progress() as report:
        return as_tasks.acquire_run(stand, steps, _home(home_folder), report)


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
    folder = _home(home_folder)
    papers = read_papers(tolerance, laboratory, order)
    run, _ = acquire(station, procedure, home_folder)
    calibration = as_tasks.estimate_items(run, folder, "jjf2003")
    return _publish(run, calibration, folder, papers)


@flow(name="calibrate", flow_run_name="calibrate {reference}")
def calibrate(
    reference: str, method: Method = "jjf2003", home_folder: str | None = None
) -> Calibration:
    """Estimate every item that a run (an id, or a path taken in on the fly) allows."""
    folder = _home(home_folder)
    run = _run(reference, folder)
    calibration = as_tasks.estimate_items(run, folder, method)
    _show_items(calibration)
    return calibration


@flow(name="certify", flow_run_name="certify {reference}")
def certify(
    reference: str,
    method: Method = "jjf2003",
    tolerance: str | None = None,
    laboratory: str | None = None,
    order: str | None = None,
    home_folder: str | None = None,
) -> Issued:
    """Estimate, decide and publish the certificate of a run."""
    folder = _home(home_folder)
    papers = read_papers(tolerance, laboratory, order)
    run = _run(reference, folder)
    calibration = as_tasks.estimate_items(run, folder, method)
    return _publish(run, calibration, folder, papers)


@flow(name="remind")
def remind(within_days: int = 30, home_folder: str | None = None) -> list[Due]:
    """List the units whose recalibration is due within so many days."""
    due = due_within(_home(home_folder), within_days)
    create_table_artifact(
        key="recalibration-due",
        table=[{"unit": d.unit, "certificate": d.certificate, "due": str(d.due)} for d in due],
        description=f"Recalibration due within {within_days} days",
    )
    return due


def _run(reference: str, folder: Home) -> store.Run:
    path = Path(reference)
    return as_tasks.take_in(path, folder)[0] if path.exists() else store.find(reference, folder)


def _publish(run: store.Run, calibration: Calibration, folder: Home, papers: Papers) -> Issued:
    _show_items(calibration)
    issued = as_tasks.publish(
        run,
        calibration,
        folder,
        tolerance=papers.tolerance,
        laboratory=papers.laboratory,
        order=papers.order,
    )
    certificate = issued.certificate
    reasons = "\n".join(f"- {reason}" for reason in certificate.decision.reasons)
    create_markdown_artifact(
        key="certificate",
        markdown=f"# {certificate.number}: {certificate.decision.verdict}\n\n{reasons}\n\n"
        f"Recalibration due {certificate.due}. PDF: `{issued.pdf}`",
        description=f"Certificate {certificate.number} of run {run.id}",
    )
    return issued


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
