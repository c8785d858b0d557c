"""What can be ordered, each order written once.

`stages` are the stages of the line as plain functions (`tasks.stages.plain`, for a person at a
terminal) or as Prefect tasks (`tasks.stages.as_tasks`, within a flow). All other parameters are
plain values, so that a schedule can order it too.
"""

from datetime import date
from pathlib import Path
from types import ModuleType

from flows import operator
from flows.ending import ending_as_by_ctrl_c
from flows.papers import read_papers, read_procedure
from flows.progress import acquisition_progress, tell
from schemas.calibration import Calibration, Method
from schemas.certificate import Laboratory
from storage import settings
from storage.catalogue import runs
from storage.catalogue.runs import Run
from storage.home import Home, home
from tasks.stages.certify import Issued
from tasks.stages.explain import Explained
from tasks.stages.record import path_of
from tasks.stages.simulate import Simulated
from tasks.station.fixture import check_attended
from tasks.station.sequence import Acquired
from tasks.station.suits import check_suits


def acquire(
    stages: ModuleType, station: str, procedure: str, home_folder: str | None, attended: bool
) -> tuple[Run, Acquired]:
    """Acquire a run from the station of a station file.

    attended: whether a person at the terminal may be asked to turn the unit over.
    """
    stand = settings.read_station(Path(station))
    steps = read_procedure(procedure)
    ask = operator.at_terminal() if attended else None
    with ending_as_by_ctrl_c(), acquisition_progress() as report:
        acquired: tuple[Run, Acquired]
        acquired = stages.acquire_run(stand, steps, place(home_folder), report, ask)
        return acquired


def check_acquisition(station: str, procedure: str, attended: bool) -> None:
    """Raises Unusable, before a flow starts, for an acquisition that cannot be carried out."""
    stand, steps = settings.read_station(Path(station)), read_procedure(procedure)
    check_suits(steps, stand)
    check_attended(steps, stand, operator.at_terminal() if attended else None)


def calibrate(
    stages: ModuleType,
    reference: str,
    method: Method | None,
    uncertainty: str,
    terms: str | None = None,
    home_folder: str | None = None,
) -> Calibration:
    """Estimate every item that a run (an id, or a path taken in on the fly) allows.

    terms: physics to take off the readings first.
    """
    folder = place(home_folder)
    run = run_of(reference, folder, stages)
    return _estimated(stages, run, folder, method, uncertainty, terms, None)


def explain(
    stages: ModuleType,
    reference: str,
    out: str | None,
    calibration: str | None,
    simulated: str | None,
    home_folder: str | None = None,
) -> Explained:
    """Say which physics the standard's model leaves out of a run."""
    folder = place(home_folder)
    run = run_of(reference, folder, stages)
    report, other = (Path(named) if named else None for named in (out, simulated))
    explained: Explained = stages.explain_run(run, folder, report, calibration, other, tell)
    return explained


def simulate(
    stages: ModuleType,
    reference: str,
    out: str,
    calibration: str | None,
    home_folder: str | None = None,
) -> Simulated:
    """Write what a unit with a calibration would have read on a run's motion."""
    folder = place(home_folder)
    run = run_of(reference, folder, stages)
    simulated: Simulated = stages.simulate_run(run, folder, Path(out), calibration)
    return simulated


def certify(
    stages: ModuleType,
    reference: str,
    method: Method | None,
    uncertainty: str,
    tolerance: str | None,
    laboratory: str | None,
    order: str | None,
    calibrated_on: date | None,
    budget: bool,
    terms: str | None = None,
    home_folder: str | None = None,
) -> Issued:
    """Estimate, decide and publish the certificate of a run. Bad papers are refused first.

    A result with terms taken off comes on a certificate only if they are ordered here.
    """
    folder = place(home_folder)
    papers = read_papers(tolerance, laboratory, order, calibrated_on, budget)
    run = run_of(reference, folder, stages)
    calibration = _estimated(stages, run, folder, method, uncertainty, terms, papers.laboratory)
    issued: Issued = stages.publish(run, calibration, folder, papers)
    return issued


def _estimated(
    stages: ModuleType,
    run: Run,
    folder: Home,
    method: Method | None,
    uncertainty: str,
    terms: str | None,
    laboratory: Laboratory | None,
) -> Calibration:
    calibration: Calibration
    if terms is None:
        calibration = stages.estimate_items(run, folder, method, uncertainty, laboratory)
    else:
        calibration = stages.adopt_terms(run, folder, terms, method, uncertainty, laboratory)
    return calibration


def run_of(reference: str, folder: Home, stages: ModuleType) -> Run:
    """The run that an order names: an id, or a path that is taken in on the fly."""
    path = path_of(reference)
    if path is None:
        return runs.find(reference, folder)
    run: Run = stages.take_in(path, folder).run
    return run


def place(home_folder: str | None) -> Home:
    """The home that an order names, else the one of this process."""
    return Home(Path(home_folder)) if home_folder else home()
