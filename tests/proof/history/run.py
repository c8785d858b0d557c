"""`make prove ARGS="--history 1000"`: history at scale, as one page of evidence."""

import os
import shutil
from pathlib import Path

from flows.progress import counting
from schemas.base import Unusable
from tasks.version import code_version
from tests.proof.history import shared
from tests.proof.history.listing import ROWS as LISTED
from tests.proof.history.listing import Listed, listed
from tests.proof.history.local import Again, again
from tests.proof.history.shared import EVERY, PAUSE_S, Shared
from tests.proof.history.store import ROWS, fill, home_at

PAGE = "history.md"
STORE = "store"
DISTURBED = 60  # recordings that are made again while the cluster is disturbed
GB = 2**30
TEXT = """# History at scale

`make prove ARGS="--history {count}"`, {version}, {cores} cores: recordings of {rows:,} rows
(variations of four), made again by two processes of this machine and by a cluster: a dask scheduler
with two workers, PostgreSQL, an S3 server and a Prefect server, all on the same {cores} cores and
all there before, as a laboratory keeps them; the two processes start a Prefect server of their own.
Bare estimation is one process that reads and calibrates a hundred, before and after, and keeps
nothing (its processor time). Efficiency is against twice its speed: of the work by the clock, and
of the whole command by the processor time of everything it needs, in which other work on the
computer does not show. Prefect's share is of that: its server meanwhile, and what a flow run with
nothing to do takes beyond the same command without one. Memory is of all processes together.
Load: the computer's average of the last minute; above 2, the column of the clock says nothing.

| | runs | failed | bare, ms | s | by the clock | by processor time | Prefect | GiB | load |
|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|
| asked | 1000 | 0 | | | 80 %, cluster 75 % | the same | 5 % | 2 | |
| two processes | {local} |
| cluster | {cluster} |

By the cluster {identical} of {count} results are bit for bit those of this machine, {twice} were
made twice.

## Disturbed

{disturbed} recordings, while a request in {every} to the bucket is answered with 500 and each waits
for {pause:g} ms: {happened}. Done: {done}, failed: {failed}, bit for bit those of this machine:
{same}, made twice: {again_twice}, in {seconds:.0f} s.

## Listing {listed:,} runs (asked: 0.3 s)

| | s | processor s | `mimucal runs`, s | processor s |
|---|--:|--:|--:|--:|
{lists}

The program's own processor time; the database's is in the seconds alone.
"""


def run_history(count: int, out: Path | None) -> None:
    """Holds it all; the page is in the folder.

    The store takes 8.4 MB for each recording, is gone on with where it is there, and is deleted at
    the end. Raises Unusable where a result differs, is missing or twice.
    """
    folder = out or Path("proof-history")
    home = home_at((folder / STORE / "home").absolute())
    with counting("recordings") as report:
        fill(home, count, report)
    local = again(home)
    undisturbed = shared.made(home, folder / STORE / "cluster", count)
    few = min(count, DISTURBED)
    disturbed = shared.made(home, folder / STORE / "disturbed", few, disturbed=True)
    page = as_page(count, local, undisturbed, disturbed, listed())
    (folder / PAGE).write_text(page, encoding="utf-8")
    print(page)
    shutil.rmtree(folder / STORE)
    if local.failed or not (undisturbed.holds and disturbed.holds):
        raise Unusable(f"history was not made again as it should; {folder / PAGE} says what")


def as_page(
    count: int, local: Again, undisturbed: Shared, disturbed: Shared, lists: list[Listed]
) -> str:
    """The page of evidence."""
    return TEXT.format(
        count=count, version=code_version(), cores=os.cpu_count(), rows=ROWS, local=_row(local),
        cluster=_row(undisturbed.again), identical=undisturbed.identical, twice=undisturbed.twice,
        disturbed=min(count, DISTURBED), every=EVERY, pause=1e3 * PAUSE_S,
        happened=", ".join(disturbed.happened), done=disturbed.again.done,
        failed=disturbed.again.failed, same=disturbed.identical, again_twice=disturbed.twice,
        seconds=disturbed.again.stage_s, listed=LISTED, lists="\n".join(map(_listed, lists)),
    )  # fmt: skip


def _row(made: Again) -> str:
    return (
        f"{made.done} | {made.failed} | {1e3 * made.bare_processor_s:.0f} | {made.stage_s:.0f} | "
        f"{made.efficiency:.0%} | {made.by_processor:.0%} | {made.prefect:.1%} | "
        f"{made.memory / GB:.2f} | {made.load:.0f}"
    )


def _listed(one: Listed) -> str:
    return (
        f"| {one.database} | {one.wall_s:.2f} | {one.processor_s:.2f} | {one.command_s:.2f} | "
        f"{one.command_processor_s:.2f} |"
    )
