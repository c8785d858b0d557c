"""Certificates issued by many processes at once, and what is wrong with their numbers.

The processes come from a server without threads: the typesetter's, which a fork would leave
behind, would be waited for without end.
"""

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
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
from tests.proof.study import Count, Out, Write, hold

ISSUER = "Zhao"
PROCESSES = 50
SERVER = get_context("forkserver")
SERVER.set_forkserver_preload(["tests.proof.issue", "typst", "pylopdf_fonts_zh_cn", "psycopg"])


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
    keys = [f"draft-{number:05d}" for number in range(1, count + 1)]
    for key in keys:
        run, _ = runs.add(recording_of(key), home)
        drawn = certificate_of(run, calibration_of(run), number=key, state="checked", steps=steps)
        keep(drawn, home)
    return keys


def issue_at_once(home: Home, keys: Sequence[str], processes: int) -> Issued:
    """Issues certificates by processes that begin at the same moment, and judges the result."""
    everybody = SERVER.Barrier(processes + 1)
    database = os.environ.get("MIMUCAL_DATABASE", "")
    shares = (keys[first::processes] for first in range(processes))
    workers = [
        SERVER.Process(target=_issue_all, args=(home, own, everybody, database), daemon=True)
        for own in shares
    ]
    for worker in workers:
        worker.start()
    everybody.wait()
    began = monotonic()
    for worker in workers:
        worker.join()
    ended = [f"a process ended with {w.exitcode}" for w in workers if w.exitcode]
    faults = (*ended, *faults_of(home, keys))
    return Issued(len(keys), processes, monotonic() - began, faults)


def _issue_all(home: Home, keys: Sequence[str], begins: Any, database: str) -> None:
    os.environ["MIMUCAL_DATABASE"] = database
    begins.wait()
    for key in keys:
        issue_one(key, home, ISSUER)


def faults_of(home: Home, keys: Sequence[str]) -> list[str]:
    """Gaps, doubles, what is not issued, files that none has, and what `verify` finds besides."""
    entries = certificates.register(home)
    faults = [f"{entry.number} is {entry.state}" for entry in entries if entry.state != "issued"]
    pattern = re.compile(rf"{LABORATORY.certificate_prefix}-\d{{4}}-(\d+)")
    found = [pattern.fullmatch(entry.number) for entry in entries if entry.state == "issued"]
    serials = sorted(int(each[1]) for each in found if each)
    if serials != list(range(1, len(keys) + 1)):
        faults.append(f"{len(keys)} certificates have the serial numbers {serials}")
    if sorted(str(entry.draft) for entry in entries if entry.state == "issued") != sorted(keys):
        faults.append("a draft was issued twice, or not at all")
    named = {Path(name).name for entry in entries for name in entry.files}
    there = {path.name for path in home.certificates.iterdir()}
    faults += [f"{name} was left over" for name in sorted(there - named)]
    wrong = (each for each in verify(home)[1] if each.why not in (LEFT_OVER, BROKEN_OFF))
    return [*faults, *(f"{fault.what}: {fault.why}" for fault in wrong)]


def issue(count: Count = 1000, out: Out = None, write: Write = False) -> None:
    """N checked certificates, issued by fifty processes at once on PostgreSQL."""
    hold("issue", {f"{count}": count}, _held, _page, out, write=write, at_once=0,
         faults=lambda one: one.faults)  # fmt: skip


def _held(count: int) -> Issued:
    with TemporaryDirectory() as name, postgres.running() as server:
        os.environ["MIMUCAL_DATABASE"] = postgres.empty_database(server)
        home = Home(Path(name))
        issued = issue_at_once(home, checked_drafts(home, count), PROCESSES)
        del os.environ["MIMUCAL_DATABASE"]
    return issued


def _page(found: Sequence[Issued]) -> str:
    (one,) = found
    return f"""# Certificates issued at once

`make prove ARGS="issue {one.count}"`: {one.processes} processes that begin at the same moment issue
{one.count:,} checked certificates into one catalogue on PostgreSQL, each with its PDF, DCC and
record, in {one.seconds:.0f} s. Held: the serial numbers are 1 to {one.count:,}, each draft was
issued once, and `verify` finds nothing in register, files, trail and series.

Faults: {"; ".join(one.faults) or "none"}.
"""
