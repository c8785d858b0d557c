"""Processes that issue certificates, each killed at a random moment."""

import os
import random
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass

from storage.catalogue import certificates
from storage.home import Home
from storage.verify import verify
from tasks.stages.issue import issue
from tests.proof.issue.at_once import checked_drafts, faults_of
from tests.proof.issue.workers import ISSUER, SERVER, issuing

LONGEST_S = 0.5  # a kill comes so long after the issue began at the latest


@dataclass(frozen=True)
class Killed:
    """How many issues were killed, and how many of them had left a certificate issued whole."""

    kills: int
    whole: int
    faults: tuple[str, ...]


def kill_issues(
    home: Home, kills: int, seed: int, report: Callable[[int, int], None] | None = None
) -> Killed:
    """Issues as many certificates; each process is killed on the way, and the next goes on.

    Whatever a kill left is judged at once: a certificate is issued whole, or checked as it was.
    In the end what was not issued is issued, and no number is missing.
    """
    draw = random.Random(seed)
    keys = checked_drafts(home, kills)
    whole, faults = 0, list[str]()
    for number, key in enumerate(keys, start=1):
        _kill_issue(home, key, draw.uniform(0.0, LONGEST_S))
        entry = _entry_of(home, key)
        whole += entry.state == "issued"
        if entry.state not in ("issued", "checked"):
            faults.append(f"{key} is {entry.state}")
        if report is not None:
            report(number, kills)
    faults += _lasting(home)
    for key in keys:
        if _entry_of(home, key).state == "checked":
            issue(key, home, ISSUER)
    return Killed(kills, whole, (*faults, *faults_of(home, keys)))


def _kill_issue(home: Home, key: str, after_s: float) -> None:
    both = SERVER.Barrier(2)
    process = issuing(home, [key], both)
    process.start()
    both.wait()
    time.sleep(after_s)
    os.kill(process.pid, signal.SIGKILL)
    process.join()


def _entry_of(home: Home, key: str) -> certificates.Entry:
    (entry,) = [each for each in certificates.register(home) if key in (each.number, each.draft)]
    return entry


def _lasting(home: Home) -> list[str]:
    """What `verify` finds: nothing but files that no certificate has is wrong after a kill."""
    return [f"{fault.what}: {fault.why}" for fault in verify(home)[1]]
