"""`python -m tests.proof.coverage`: how often stated intervals hold the truth on other tables."""

import os
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from schemas.calibration import TARGET_SHARE, Coverage, Method
from tasks.calibrate.calibrate import calibrate, evaluation_for
from tasks.specifications.register import SPECIFICATIONS
from tasks.validation.coverage import Errors, errors_of, interval_of_share, summarise
from tests.proof.coverage.other_tables import OTHERS
from tests.proof.study import EVIDENCE, line, table


def errors_on(job: tuple[str, Method, int]) -> Errors:
    """One unit simulated on such a table and calibrated by a method."""
    kind, method, seed = job
    _, make, own = OTHERS[kind]
    recording, truth = make(method, seed)
    made = calibrate(
        SPECIFICATIONS[method], recording, run="simulated", code_version="-",
        evaluation=evaluation_for(recording, own=own),
    )  # fmt: skip
    return errors_of(made, truth)


def main(units: int, seed: int) -> None:
    """Print a line for each element outside of 93 to 97 %, and write the report."""
    lines = [
        "# Coverage on other tables", "",
        f"{units} units each, seeds from {seed} on; share of the truths within the stated 95 % "
        "interval. Below and above are named where the 95 % interval of the share itself (Wilson) "
        "is outside of 93 to 97 %.", "",
        *table(("table", "method", "elements", "within 93 to 97 %", "below", "above"), ()),
    ]  # fmt: skip
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        for kind, (methods, _, _) in OTHERS.items():
            for method in methods:
                jobs = [(kind, method, seed + i) for i in range(units)]
                found = summarise(pool.map(errors_on, jobs, chunksize=4))
                lines.append(_row(kind, method, found))
                print(lines[-1], flush=True)
    (EVIDENCE / "coverage.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _row(kind: str, method: str, found: dict[str, Coverage]) -> str:
    by = {f"{item}.{e}": (x, c.units) for item, c in found.items() for e, x in c.by_element.items()}
    low, high = TARGET_SHARE
    short = ", ".join(
        f"{e} {100 * x:.1f}" for e, (x, n) in by.items() if interval_of_share(x, n)[1] < low
    )
    long = ", ".join(
        f"{e} {100 * x:.1f}" for e, (x, n) in by.items() if interval_of_share(x, n)[0] > high
    )
    inside = sum(low <= x <= high for x, _ in by.values())
    return line((kind, method, len(by), inside, short or "—", long or "—"))


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
