"""Stage: every item that a run allows is estimated, and the result is kept."""

from schemas.base import Unusable
from schemas.calibration import Calibration, Method
from storage import store
from storage.home import Home
from storage.store import Run
from tasks.items import jjf2003
from tasks.version import code_version

METHODS = {"jjf2003": jjf2003.calibrate}


def check_method(method: str) -> None:
    """Raises Unusable for a method that this version does not have."""
    if method not in METHODS:
        raise Unusable(
            f"--method {method}: this version estimates by {', '.join(METHODS)}; choose that"
        )


def estimate(run: Run, home: Home, method: Method = "jjf2003") -> Calibration:
    """Calibrate a run by one method and keep the result; the same result twice is one."""
    check_method(method)
    recording = store.load(run, home)
    calibration = METHODS[method](recording, run=run.id, code_version=code_version())
    store.save_result(calibration, home)
    return calibration
