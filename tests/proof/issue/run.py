"""`make prove ARGS="--issue N"`: at once on PostgreSQL, killed on SQLite, and the page of it."""

import os
import tempfile
from pathlib import Path

from flows.progress import counting
from storage.home import Home
from tests import postgres
from tests.proof.issue.at_once import checked_drafts, issue_at_once
from tests.proof.issue.kills import LATEST, kill_issues
from tests.proof.report import publish

PROCESSES = 50
KILLS = 100
TEXT = """# Certificates issued at once, and issues that are killed

`make prove ARGS="--issue {count} --seed {seed}"`: {processes} processes that begin at the same
moment issue {count:,} checked certificates into one catalogue on PostgreSQL, each with its PDF, DCC
and record, in {seconds:.0f} s ({rate:.1f} a second: one at a time, since each is made between
taking its number and the end of the transaction). Held: the serial numbers are 1 to {count:,}, each
draft was issued once, and `verify` finds nothing in register, files, trail and series.

Faults: {at_once}.

{kills} issues (SQLite) were killed by SIGKILL at a random moment within {longest:.2f} s; {whole} of
them had left a certificate issued whole, the others were as they had been, checked and without a
number. Then the others were issued, and no number is missing or given twice. Files that no
certificate has, of issued drafts or broken off in the writing: {left}; `verify` names them.

Faults: {killed}.
"""


def run_issue(count: int, seed: int, write: bool) -> None:
    """Hold it and print the page; exit 1 where something is wrong. write: into the evidence."""
    with tempfile.TemporaryDirectory() as name, postgres.running() as server:
        os.environ["MIMUCAL_DATABASE"] = postgres.empty_database(server)
        home = Home(Path(name))
        issued = issue_at_once(home, checked_drafts(home, count), PROCESSES)
        del os.environ["MIMUCAL_DATABASE"]
    with tempfile.TemporaryDirectory() as name, counting("kills") as report:
        killed = kill_issues(Home(Path(name)), min(KILLS, count), seed, report)
    page = TEXT.format(
        count=count, seed=seed, processes=PROCESSES, seconds=issued.seconds,
        rate=count / issued.seconds,
        at_once="; ".join(issued.faults) or "none", kills=killed.kills,
        longest=LATEST * killed.seconds,
        whole=killed.whole, left=killed.left_over, killed="; ".join(killed.faults) or "none",
    )  # fmt: skip
    publish("issue.md", page, write, bool(issued.faults or killed.faults))
