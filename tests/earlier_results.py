"""Two calibrated runs, and results of them as earlier code would have made them."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from schemas.calibration import Calibration
from schemas.orders import CalibrateOrder
from schemas.recording import Recording
from storage.catalogue import results, runs
from storage.home import Home
from tasks.stages.estimate import estimate

EARLIER = "0.0.9+earlier"


def two_calibrated(home: Path, ideal_run: Callable[..., Recording]) -> Home:
    """A store of two runs, calibrated."""
    kept = Home(home)
    for off in (1.0, 1.01):
        run, _ = runs.add(ideal_run(dwell=2.0, Kg=off * np.eye(3)), kept)
        estimate(run, kept, CalibrateOrder(run=run.id))
    return kept


def newest(home: Home) -> list[Calibration]:
    return [results.of_run(run, home)[-1].calibration for run in runs.all_runs(home)]


def plant(result: Calibration, home: Home, item: str, element: str, by: float) -> Calibration:
    """Keeps a result as earlier code made it: one value of it was another by so many U."""
    was = result.items[item]
    moved = was.value[element] - by * was.U[element]
    items = result.items | {item: was.model_copy(update={"value": was.value | {element: moved}})}
    earlier = result.model_copy(update={"items": items, "code_version": EARLIER})
    results.save(earlier, home)
    return earlier
