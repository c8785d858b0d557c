"""Carries out each order stage by stage, inside a Prefect flow or outside of one.

The stages are imported when an order needs them: `calibrate` starts without those of the
certificate.
"""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from flows import terminal
from flows.signals import cancellation_watch, ending_as_ctrl_c, pausing, resilient_output, stopping
from flows.terminal import counting, describe
from schemas.base import Unusable
from schemas.orders import (
    AcquireOrder,
    AmendOrder,
    ApplyOrder,
    CalibrateOrder,
    CertifyOrder,
    CheckOrder,
    ExplainOrder,
    IssueOrder,
    NextOrder,
    OrderModel,
    ReprocessOrder,
    ReviewOrder,
    SimulateOrder,
    WithdrawOrder,
)
from schemas.station import StationFile
from storage import settings
from storage.home import Home, home
from storage.stations import file_named, release
from tasks.stages.authority import authorised_operator
from tasks.stages.import_recording import run_of
from tasks.stages.stop import current_user

if TYPE_CHECKING:
    from collections.abc import Callable

    from schemas.calibration import Calibration
    from schemas.certificate import Replaced
    from schemas.discrepancy import NextRecording
    from schemas.history import Reprocessing
    from schemas.orders import Estimation
    from schemas.procedure import Procedure
    from tasks.stages.acquire import AcquiredRuns
    from tasks.stages.certificate_inputs import CertificateInputs
    from tasks.stages.certify import Published
    from tasks.stages.correct import Corrected, Simulated
    from tasks.stages.explain import Explained
    from tasks.stages.review import Reviewed
    from tasks.station.ports import Ask


def acquire(order: AcquireOrder) -> "AcquiredRuns":
    """Acquire a run from a station; Unusable and BrokenOff say where an interrupted one is."""
    from flows.acquisition_view import acquisition_view
    from tasks.stages.acquire import acquire_run
    from tasks.station.connected_station import StopSwitch

    station, procedure, ask = _acquisition(order)
    place, stop = home_of(order), StopSwitch()
    operator = authorised_operator(order.by, procedure.standard, settings.laboratory(place))
    with (
        resilient_output(),
        stopping(stop),
        cancellation_watch(stop.press),
        pausing() as is_paused,
        acquisition_view() as report,
    ):
        return acquire_run(
            station, procedure, place, report, ask, is_paused, order.resume, stop, operator
        )


def check_acquisition(order: AcquireOrder) -> None:
    """Raises Unusable, before a flow starts, for an acquisition that cannot be carried out."""
    from tasks.station.acquisition import check_run

    station, procedure, ask = _acquisition(order)
    check_run(procedure, station, ask)
    authorised_operator(order.by, procedure.standard, settings.laboratory(home_of(order)))


def release_station(order: AcquireOrder) -> None:
    """Whoever starts a run by hand has seen that the station may turn after a stop."""
    place = home_of(order)
    station = settings.read(file_named(order.station, place), StationFile).station.id
    release(station, order.by or current_user(), place)


def _acquisition(order: AcquireOrder) -> "tuple[StationFile, Procedure, Ask | None]":
    file = file_named(order.station, home_of(order))
    station, procedure = settings.read(file, StationFile), procedure_of(order)
    if order.units:
        try:
            station = station.with_units(order.units)
        except ValueError as fault:
            raise Unusable(f"units: {fault}; order one for each place") from fault
    return station, procedure, terminal.at_terminal() if order.attended else None


def calibrate(order: CalibrateOrder) -> "Calibration":
    """Estimate every item that a run (an id, or a path imported on the fly) allows."""
    from tasks.stages.estimate import estimate

    place = home_of(order)
    return estimate(run_of(order.run, place), place, order)


def explain(order: ExplainOrder) -> "Explained":
    """Find where model and run differ, which physics was left out, and how much it matters."""
    from tasks.stages.explain import explain_run

    place = home_of(order)
    if order.others:
        from tasks.stages.explain import explain_together

        every = [run_of(each, place) for each in (order.run, *order.others)]
        return explain_together(every, place, order, describe)
    return explain_run(run_of(order.run, place), place, order, describe)


def review(order: ReviewOrder) -> "Reviewed":
    """Find what many runs show together, what carries it and since when."""
    from tasks.stages.review import review_runs

    with counting("runs") as report:
        return review_runs(order, home_of(order), report)


def next_recording(order: NextOrder) -> "NextRecording":
    """Propose the recording that settles what the explanations of some runs left open."""
    from tasks.stages import next_recording as stage

    place = home_of(order)
    every = [run_of(each, place) for each in order.runs]
    return stage.next_recording(every, place, order, describe)


def simulate(order: SimulateOrder) -> "Simulated":
    """Simulate the readings of a calibrated unit for the motion of a run."""
    from tasks.stages.correct import simulate_run

    place = home_of(order)
    return simulate_run(run_of(order.run, place), place, order)


def apply(order: ApplyOrder) -> "Corrected":
    """Write a run corrected for its unit's errors."""
    from tasks.stages.correct import apply_correction

    place = home_of(order)
    return apply_correction(run_of(order.run, place), place, order)


def certify(order: CertifyOrder) -> "Published":
    """Estimate, decide and draft the certificate of a run. Unusable files are refused first.

    A result with corrected terms is used only if these terms are ordered here.
    """
    from tasks.stages.certificate_inputs import read_inputs

    return _certified(home_of(order), order.run, order.as_found, order, read_inputs(order))


def amend(order: AmendOrder) -> "Published":
    """Draft the certificate that replaces an issued one."""
    from tasks.stages.issue import amendment

    place = home_of(order)
    new = amendment(order, place)
    return _certified(place, new.run, new.as_found, new.how, new.inputs, new.replaces)


def _certified(
    place: Home,
    run_reference: str,
    found_reference: str | None,
    how: "Estimation",
    inputs: "CertificateInputs",
    replaces: "Replaced | None" = None,
) -> "Published":
    from tasks.stages import certify as stage
    from tasks.stages.estimate import estimate

    if inputs.order and inputs.order.axes:
        how = how.model_copy(update={"axes": inputs.order.axes})
    run = run_of(run_reference, place)
    found = run_of(found_reference, place) if found_reference is not None else None
    calibration = estimate(run, place, how, inputs.laboratory)
    as_found = (found, estimate(found, place, how, inputs.laboratory)) if found else None
    return stage.certify(run, calibration, place, inputs, as_found, replaces)


def check(order: CheckOrder) -> "Published":
    """Record that a person checked a draft."""
    from tasks.stages import issue as stage

    return stage.check(order.certificate, home_of(order), order.by, order.reason)


def issue(order: IssueOrder) -> "Published":
    """Issue a checked certificate under the laboratory's next number."""
    from tasks.stages import issue as stage

    return stage.issue(order.certificate, home_of(order), order.by, order.reason)


def withdraw(order: WithdrawOrder) -> "Published":
    """Withdraw an issued certificate."""
    from tasks.stages import issue as stage

    return stage.withdraw(order.certificate, home_of(order), order.by, order.why)


def reprocess(
    order: ReprocessOrder, report: "Callable[[int, int], None] | None" = None
) -> "Reprocessing":
    """Re-process the results of a selection; calls report(done, total) after each."""
    from tasks.stages import reprocess as stage

    def report_progress(done: int, total: int) -> None:
        show(done, total)
        if report is not None:
            report(done, total)

    with ending_as_ctrl_c(), counting("reprocess") as show:
        return stage.reprocess(order, home_of(order), report_progress)


def home_of(order: OrderModel) -> Home:
    """The home named by an order, else that of this process."""
    return Home(Path(order.home)) if order.home else home()


def procedure_of(order: AcquireOrder) -> "Procedure":
    """A procedure by name, or from a file of that name."""
    from tasks.stages.acquire import procedure_named

    return procedure_named(order.procedure)
