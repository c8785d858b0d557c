"""`make bench`: every measurement with its limit measured in the same run, as one report.

python -m tests.bench [--out DIR] [--rows N]; frames are measured by `python -m
tests.bench.bench_frames`, which takes minutes.
"""

import argparse
import os
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy is there, as the program itself does

from tests.bench import (
    bench_calibrate,
    bench_history,
    bench_mcap,
    bench_pages,
    bench_peers,
    bench_review,
    report,
)
from tests.surroundings import leave_production


def main() -> None:
    """Measure, print and write the report."""
    leave_production()
    parser = argparse.ArgumentParser(prog="python -m tests.bench")
    parser.add_argument("--out", type=Path, default=Path("bench"), help="folder of the report")
    parser.add_argument("--rows", type=int, default=1_440_000, help="of the run in store")
    given = parser.parse_args()
    parts = (
        lambda: bench_calibrate.in_store(given.rows),
        bench_mcap.reading,
        bench_calibrate.commands,
        bench_calibrate.by_samples,
        bench_history.by_workers,
        bench_history.prefect,
        bench_review.many_runs,
        bench_peers.ferraris,
        bench_peers.allan,
        bench_pages.pages,
    )
    sections = []
    for part in parts:
        sections.append(part())
        report.write(sections, given.out)
        print(report.markdown(sections[-1:]).split("\n", 4)[-1], flush=True)
    print(f"report: {given.out / 'speed.md'}")


if __name__ == "__main__":
    main()
