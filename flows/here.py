"""The orders carried out in this process, without Prefect, for a person at a terminal.

The same stages as the flows of `flows.line`, so the same results.
"""

from schemas.calibration import Calibration, Method
from storage.home import home
from tasks.stages.certify import Issued
from tasks.stages.estimate import estimate
from tasks.stages.record import run_of


def calibrate(reference: str, method: Method) -> Calibration:
    """Estimate every item that a run allows."""
    return estimate(run_of(reference, home()), home(), method)


def certify(
    reference: str,
    method: Method,
    tolerance: str | None,
    laboratory: str | None,
    order: str | None,
) -> Issued:
    """Estimate, decide and publish the certificate of a run."""
    from flows.papers import read_papers
    from tasks.stages.certify import certify as publish

    papers = read_papers(tolerance, laboratory, order)
    run = run_of(reference, home())
    calibration = estimate(run, home(), method)
    return publish(
        run,
        calibration,
        home(),
        tolerance=papers.tolerance,
        laboratory=papers.laboratory,
        order=papers.order,
    )
