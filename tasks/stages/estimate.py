"""Stage: every item that a run allows is estimated, and the result is kept."""

from schemas.base import Unusable
from schemas.calibration import Calibration, Method
from schemas.recording import Standard
from storage import store
from storage.home import Home
from storage.store import Run
from tasks.items import jjf1536, jjf2003
from tasks.version import code_version

METHODS = {"jjf2003": jjf2003.calibrate, "jjf1536": jjf1536.calibrate}
BY_STANDARD: dict[Standard, Method] = {"JJF 1536-2015": "jjf1536"}


def check_method(method: str | None) -> None:
    """Raises Unusable for a method that this version does not have."""
    if method is not None and method not in METHODS:
        raise Unusable(
            f"--method {method}: this version estimates by {' or '.join(METHODS)}; choose one"
        )


def estimate(run: Run, home: Home, method: Method | None = None) -> Calibration:
    """Calibrate a run and keep the result; the same result twice is one.

    method: that of the specification the recording was made for, unless told.
    """
    check_method(method)
    recording = store.load(run, home)
    method = method or BY_STANDARD.get(recording.manifest.standard, "jjf2003")
    calibration = METHODS[method](recording, run=run.id, code_version=code_version())
    store.save_result(calibration, home)
    return calibration
