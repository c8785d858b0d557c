"""Processes that issue certificates.

They come from a server without threads: the typesetter's, which a fork would leave behind, would
be waited for without end.
"""

import os
import random
import re
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from time import monotonic
from typing import Any

from schemas.certificate import Step
from storage.catalogue import certificates, runs
from storage.home import Home
from storage.verify import BROKEN_OFF, LEFT_OVER, verify
from tasks.stages.issue import issue as issue_one
from tests import postgres
from tests.drafts import LABORATORY, MORNING, calibration_of, certificate_of, recording_of
from tests.keep import keep
from tests.proof.study import Count, Out, Seed, Write, hold

ISSUER = "Zhao"
PRELOADED = ["tests.proof.issue", "typst", "pylopdf_fonts_zh_cn", "psycopg"]

SERVER = get_context("forkserver")
SERVER.set_forkserver_preload(PRELOADED)


def issuing(home: Home, keys: Sequence[str], begins: Any) -> Any:
    """A process, not started, that waits at a barrier and then issues one after the other."""
    database = os.environ.get("MIMUCAL_DATABASE", "")
    return SERVER.Process(target=_issue_all, args=(home, keys, begins, database), daemon=True)


def _issue_all(home: Home, keys: Sequence[str], begins: Any, database: str) -> None:
    os.environ["MIMUCAL_DATABASE"] = database
    begins.wait()
    for key in keys:
        issue_one(key, home, ISSUER)


# Certificates issued by many processes at once, and what is wrong with their numbers.

IN_NOBODYS_WAY = (LEFT_OVER, BROKEN_OFF)


@dataclass(frozen=True)
class Issued:
    """What came of it: certificates, processes, seconds, and every fault."""

    count: int
    processes: int
    seconds: float
    faults: tuple[str, ...]


def checked_drafts(home: Home, count: int) -> list[str]:
    """Keys of drafts that were checked, each of a run of its own."""
    steps = (
        Step(step="draft", person="Wang", at=MORNING),
        Step(step="check", person="Li", at=MORNING),
    )
    keys = []
    for number in range(1, count + 1):
        run, _ = runs.add(recording_of(f"U{number:05d}"), home)
        key = f"draft-{number:05d}"
        keep(
            certificate_of(run, calibration_of(run), number=key, state="checked", steps=steps), home
        )
        keys.append(key)
    return keys


def issue_at_once(home: Home, keys: Sequence[str], processes: int) -> Issued:
    """Issues certificates by processes that begin at the same moment, and judges the result."""
    everybody = SERVER.Barrier(processes + 1)
    workers = [issuing(home, keys[first::processes], everybody) for first in range(processes)]
    for worker in workers:
        worker.start()
    everybody.wait()
    began = monotonic()
    for worker in workers:
        worker.join()
    seconds = monotonic() - began
    ended = [f"a process ended with {w.exitcode}" for w in workers if w.exitcode]
    left = [f"{name} was left over" for name in left_over(home)]
    return Issued(len(keys), processes, seconds, (*ended, *left, *faults_of(home, keys)))


def faults_of(home: Home, keys: Sequence[str]) -> list[str]:
    """Gaps, doubles, what is not issued, and what `verify` finds beside files left over."""
    entries = certificates.register(home)
    issued = [entry for entry in entries if entry.state == "issued"]
    faults = [f"{entry.number} is {entry.state}" for entry in entries if entry.state != "issued"]
    pattern = re.compile(rf"{LABORATORY.certificate_prefix}-\d{{4}}-(\d+)")
    found = [pattern.fullmatch(entry.number) for entry in issued]
    serials = sorted(int(each[1]) for each in found if each)
    if serials != list(range(1, len(keys) + 1)):
        faults.append(f"{len(keys)} certificates have the serial numbers {serials}")
    if sorted(str(entry.draft) for entry in issued) != sorted(keys):
        faults.append("a draft was issued twice, or not at all")
    return faults + lasting(home)


def lasting(home: Home) -> list[str]:
    """What `verify` finds but for files that no certificate has, which stand in nobody's way."""
    found = verify(home)[1]
    return [f"{fault.what}: {fault.why}" for fault in found if fault.why not in IN_NOBODYS_WAY]


def left_over(home: Home) -> list[str]:
    """Files beside the certificates that none of them has."""
    named = {Path(name).name for entry in certificates.register(home) for name in entry.files}
    return sorted({path.name for path in home.certificates.iterdir()} - named)


# Processes that issue certificates, each killed at a random moment.

LATEST = 1.5  # a kill comes so much of the time of a whole issue after its beginning at the latest


@dataclass(frozen=True)
class Killed:
    """How many issues were killed, and how many of them had left a certificate issued whole.

    seconds: that one takes which is not killed. left_over: files of drafts that were issued, and
    files that were being written, which nothing names.
    """

    kills: int
    whole: int
    seconds: float
    left_over: int
    faults: tuple[str, ...]


def kill_issues(home: Home, kills: int, seed: int) -> Killed:
    """Issues as many certificates, and one before that shows how long it takes.

    Each process is killed on the way, and the next goes on. Whatever a kill left is judged: a
    certificate is issued whole, or checked as it was. In the end what was not issued is issued,
    and no number is missing.
    """
    draw = random.Random(seed)
    first, *keys = checked_drafts(home, kills + 1)
    whole_s = _issue(home, first)
    whole, faults = 0, list[str]()
    for number, key in enumerate(keys, start=1):
        # A random moment of each part of the time, so that few kills reach every part of an issue.
        _issue(home, key, (number - draw.random()) / kills * LATEST * whole_s)
        entry = _entry_of(home, key)
        whole += entry.state == "issued"
        if entry.state not in ("issued", "checked"):
            faults.append(f"{key} is {entry.state}")
    faults += lasting(home)
    for key in keys:
        if _entry_of(home, key).state == "checked":
            issue_one(key, home, ISSUER)
    left = left_over(home)
    faults += [f"{name} was left over" for name in left if not name.startswith(("draft-", "."))]
    return Killed(kills, whole, whole_s, len(left), (*faults, *faults_of(home, [first, *keys])))


def _issue(home: Home, key: str, kill_after_s: float | None = None) -> float:
    """Seconds from the beginning of an issue until its process has ended, or was killed."""
    both = SERVER.Barrier(2)
    process = issuing(home, [key], both)
    process.start()
    both.wait()
    began = time.monotonic()
    if kill_after_s is not None:
        time.sleep(kill_after_s)
        process.kill()
    process.join()
    return time.monotonic() - began


def _entry_of(home: Home, key: str) -> certificates.Entry:
    (entry,) = [each for each in certificates.register(home) if key in (each.number, each.draft)]
    return entry


PROCESSES = 50
KILLS = 100
TEXT = """# Certificates issued at once, and issues that are killed

`make prove ARGS="issue {count} --seed {seed}"`: {processes} processes that begin at the same
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


def issue(count: Count = 1000, seed: Seed = 1, out: Out = None, write: Write = False) -> None:
    """Certificates issued at once on PostgreSQL, and issues killed on SQLite."""
    work = {f"{seed}-{count}-{what}": what for what in ("at once", "killed")}
    hold("issue", work, partial(held, count=count, seed=seed), partial(page, count, seed), out,
         write=write, at_once=0, faults=lambda one: one.faults)  # fmt: skip


def held(what: str, count: int, seed: int) -> Issued | Killed:
    """One half of it."""
    with tempfile.TemporaryDirectory() as name:
        if what == "killed":
            return kill_issues(Home(Path(name)), min(KILLS, count), seed)
        with postgres.running() as server:
            os.environ["MIMUCAL_DATABASE"] = postgres.empty_database(server)
            home = Home(Path(name))
            issued = issue_at_once(home, checked_drafts(home, count), PROCESSES)
            del os.environ["MIMUCAL_DATABASE"]
            return issued


def page(count: int, seed: int, both: Sequence[Issued | Killed]) -> str:
    issued, killed = both
    assert isinstance(issued, Issued)
    assert isinstance(killed, Killed)
    return TEXT.format(
        count=count, seed=seed, processes=PROCESSES, seconds=issued.seconds,
        rate=count / issued.seconds,
        at_once="; ".join(issued.faults) or "none", kills=killed.kills,
        longest=LATEST * killed.seconds,
        whole=killed.whole, left=killed.left_over, killed="; ".join(killed.faults) or "none",
    )  # fmt: skip
