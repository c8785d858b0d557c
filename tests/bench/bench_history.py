"""Re-processing many recordings: beside the bare estimation, by workers, and what Prefect costs."""

import tempfile
from functools import partial
from pathlib import Path

from flows.on_prefect.server import connect
from schemas.orders import CalibrateOrder, ReprocessOrder
from storage.catalogue import runs
from storage.catalogue.runs import Run
from storage.home import Home
from tasks.stages.estimate import estimate
from tasks.stages.reprocess import reprocess
from tests.bench.measure import Figure, Section, processor_s, wall_s
from tests.bench.recordings import recording

RECORDINGS, ROWS = 16, 150_000
FLOWS = 5
WORKERS = (1, 2)


def by_workers(count: int = RECORDINGS) -> Section:
    """Wall seconds for each recording of 150,000 rows; the machine should have nothing else to do.

    Workers start anew, so that a few recordings show mostly their start.
    """
    figures = []
    for workers in (0, *WORKERS):
        with tempfile.TemporaryDirectory() as folder:
            home = Home(Path(folder))
            taken_in = [runs.add(recording(ROWS, seed), home)[0] for seed in range(count)]
            bare = wall_s(partial(_estimate_all, taken_in, home))
            if not workers:
                figures.append(Figure("bare estimation, one core", bare / count))
                continue
            order = ReprocessOrder(workers=workers)
            seconds = wall_s(partial(reprocess, order, home, lambda done, total: None))
            figures.append(Figure(f"reprocess, {workers} worker(s)", seconds / count))
    return Section(
        f"Re-processing {count} recordings of {ROWS:,} rows (wall time of each)", tuple(figures),
        "Two workers at 80 % of two cores are 1.6 times as fast as the first line.", faster=True,
    )  # fmt: skip


def prefect() -> Section:
    """What a flow run adds to the estimation of one recording, in this process."""
    with tempfile.TemporaryDirectory() as folder:
        home = Home(Path(folder))
        run, _ = runs.add(recording(ROWS), home)
        bare = processor_s(partial(estimate, run, home))
        connect(home)
        from flows.on_prefect import flows

        order = CalibrateOrder(run=run.id, home=folder)
        work = partial(flows.run_now, flows.calibrate, order)
        flow = processor_s(work, FLOWS)
    note = f"One flow run costs {flow - bare:.2f} s, whatever is in it; `reprocess` is one flow."
    figures = (Figure("estimation", bare), Figure("the same as a flow run of its own", flow))
    return Section("Prefect's fixed cost of a recording", figures, note)


def _estimate_all(taken_in: list[Run], home: Home) -> None:
    for run in taken_in:
        estimate(run, home)
