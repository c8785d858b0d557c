"""Stage: every item that a run allows is estimated, and the result is kept."""

from schemas.base import Unusable
from schemas.calibration import Calibration, Method, UncertaintyKind
from schemas.certificate import Laboratory
from schemas.recording import Standard
from storage import settings
from storage.catalogue import results, runs
from storage.catalogue.runs import Run
from storage.home import Home
from tasks.specifications import jjf1536, jjf2003, joint
from tasks.specifications.evaluation import evaluation_for
from tasks.version import code_version

METHODS = {
    "jjf2003": jjf2003.calibrate,
    "joint": joint.calibrate,
    "jjf1536": jjf1536.calibrate,
}
BY_STANDARD: dict[Standard, Method] = {"JJF 1536-2015": "jjf1536"}

UNCERTAINTIES: dict[str, UncertaintyKind] = {
    "gum": "GUM",
    "montecarlo": "Monte Carlo",
    "example": "as the specification's example",
}


def check_method(method: str | None) -> None:
    """Raises Unusable for a method that this version does not have."""
    if method is not None and method not in METHODS:
        raise Unusable(
            f"--method {method}: this version estimates by {' or '.join(METHODS)}; choose one"
        )


def check_uncertainty(name: str) -> None:
    """Raises Unusable for an evaluation of uncertainty that there is not."""
    if name not in UNCERTAINTIES:
        raise Unusable(
            f"--uncertainty {name}: uncertainties are evaluated by "
            f"{', '.join(UNCERTAINTIES)}; "
            "choose one"
        )


def estimate(
    run: Run,
    home: Home,
    method: Method | None = None,
    uncertainty: str = "gum",
    laboratory: Laboratory | None = None,
) -> Calibration:
    """Calibrate a run and keep the result; the same result twice is one.

    method: that of the specification the recording was made for, unless told. uncertainty: gum,
    montecarlo or example. laboratory: whose limits go before those of the specification's Table 1;
    that of the home, unless told.
    """
    check_method(method)
    check_uncertainty(uncertainty)
    recording = runs.load(run, home)
    method = method or BY_STANDARD.get(recording.manifest.standard, "jjf2003")
    laboratory = laboratory or settings.laboratory(home)
    own = laboratory.limits if laboratory else None
    calibration = METHODS[method](
        recording,
        run=run.id,
        code_version=code_version(),
        evaluation=evaluation_for(recording, UNCERTAINTIES[uncertainty], own),
    )
    results.save(calibration, home)
    return calibration
