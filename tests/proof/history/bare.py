"""Estimation of runs one after the other in one process: read, calibrated, not kept.

python -m tests.proof.history.bare COUNT: seconds of each in wall and processor time, as JSON.
"""

import json
import sys
import time

from schemas.orders import Estimation
from storage.catalogue import run_index
from storage.home import home
from tasks.stages.estimate import calibration_of

WARM_UP = 5


def main(count: int) -> None:
    """Print the figures of so many runs of the home."""
    some = run_index.all_runs(home())[: count + WARM_UP]
    for run in some[:WARM_UP]:
        calibration_of(run, home(), Estimation(), None)
    began, worked = time.perf_counter(), time.process_time()
    for run in some[WARM_UP:]:
        calibration_of(run, home(), Estimation(), None)
    measured = max(1, len(some) - WARM_UP)
    wall, work = time.perf_counter() - began, time.process_time() - worked
    print(json.dumps({"wall_s": wall / measured, "processor_s": work / measured}))


if __name__ == "__main__":
    main(int(sys.argv[1]))
