"""Processes that issue certificates, each killed at a random moment."""

import random
import time
from collections.abc import Callable
from dataclasses import dataclass

from storage.catalogue import certificates
from storage.home import Home
from tasks.stages.issue import issue
from tests.proof.issue.at_once import checked_drafts, faults_of, lasting, left_over
from tests.proof.issue.workers import ISSUER, SERVER, issuing

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


def kill_issues(
    home: Home, kills: int, seed: int, report: Callable[[int, int], None] | None = None
) -> Killed:
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
        if report is not None:
            report(number, kills)
    faults += lasting(home)
    for key in keys:
        if _entry_of(home, key).state == "checked":
            issue(key, home, ISSUER)
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
