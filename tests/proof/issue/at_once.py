"""Certificates issued by many processes at once, and what is wrong with their numbers."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import monotonic

from schemas.certificate import Step
from storage.catalogue import certificates, runs
from storage.home import Home
from storage.verify import BROKEN_OFF, LEFT_OVER, verify
from tests.drafts import LABORATORY, MORNING, calibration_of, certificate_of, recording_of
from tests.keep import keep
from tests.proof.issue.workers import SERVER, issuing

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
