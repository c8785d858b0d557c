"""Diagnoses this machine and this home, and says what to do; changes nothing."""

import os
import stat
import sys
from collections.abc import Callable, Iterator
from datetime import UTC, datetime, timedelta
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement

from schemas.base import Unusable
from schemas.certificate import Laboratory
from schemas.recording import ENDED
from schemas.store import Diagnosis, Examined
from storage import settings
from storage.catalogue import audit_trail, runs
from storage.formats.mcap.reader import has_readings
from storage.home import Home, environment
from storage.stations import statuses
from tasks.conformity import check_capabilities
from tasks.stages.prefect_api import NotAnswered, get, is_open, post
from tasks.stages.store import FREE_BYTES, free_bytes
from tasks.validation import record

# Whether the Prefect server that is named does what a line asks of it.

LATE = timedelta(minutes=10)  # longer than the polling interval of any worker
MEMORY = "lease_storage.memory"
LIVE = "ONLINE"


def examine_prefect() -> Iterator[Examined]:
    """The server, whom it lets in, its leases, its schedules, and the workers of each pool."""
    url = environment().prefect_server
    if not url:
        yield Examined(what="Prefect", found="no server named: a command starts its own")
        return
    try:
        get("/health")
        server = get("/admin/settings")["server"]
        deployments = post("/deployments/filter", {})
        looks = (_schedules(deployments), _workers(deployments))
        rest = [*_server(server), *(one for look in looks for one in look)]
    except NotAnswered as fault:
        yield Examined(
            what="Prefect",
            found=str(fault),
            remedy="Start that server, mend PREFECT_API_URL or PREFECT_API_AUTH_STRING, or unset "
            "PREFECT_API_URL.",
        )
        return
    yield Examined(what="Prefect", found=f"{url} answers")
    yield from rest


def _server(settings: dict[str, Any]) -> Iterator[Examined]:
    anyone = is_open()
    yield Examined(
        what="Prefect's door",
        found="whoever reaches it may order" if anyone else "asks for a password",
        remedy="Set PREFECT_SERVER_API_AUTH_STRING for the server, and PREFECT_API_AUTH_STRING for "
        "everything else." if anyone else None,
    )  # fmt: skip
    is_lost = str(settings["concurrency"]["lease_storage"]).endswith(MEMORY)
    yield Examined(
        what="Prefect's leases",
        found="in the server's memory" if is_lost else "outlive the server",
        remedy="Set PREFECT_SERVER_CONCURRENCY_LEASE_STORAGE for the server to "
        "prefect.server.concurrency.lease_storage.filesystem." if is_lost else None,
    )  # fmt: skip


def _schedules(deployments: list[dict[str, Any]]) -> Iterator[Examined]:
    """A working schedule has a future run, and none that is long overdue."""
    scheduled = [each for each in deployments if _is_scheduled(each)]
    without = [each["name"] for each in scheduled if not _runs(each, {"type": "SCHEDULED"})]
    overdue = {"before_": (datetime.now(UTC) - LATE).isoformat()}
    late = [each["name"] for each in scheduled if _runs(each, {"name": "Late"}, overdue)]
    faults = [f"{name} has no run to come" for name in without]
    faults += [f"{name} has runs that are late" for name in late]
    yield Examined(
        what="Prefect's schedules",
        found="; ".join(faults) or f"{len(scheduled)} produce runs",
        remedy="See the server's log where no run is to come, and start the worker of the pool "
        "where runs are late." if faults else None,
    )  # fmt: skip


def _is_scheduled(deployment: dict[str, Any]) -> bool:
    active = any(schedule["active"] for schedule in deployment["schedules"])
    return active and not deployment["paused"]


def _runs(
    deployment: dict[str, Any], state: dict[str, str], expected: dict[str, str] | None = None
) -> int:
    of_state = {name: {"any_": [value]} for name, value in state.items()}
    runs: dict[str, Any] = {"state": of_state}
    if expected:
        runs["expected_start_time"] = expected
    asked = {"deployments": {"id": {"any_": [deployment["id"]]}}, "flow_runs": runs}
    return int(post("/flow_runs/count", asked))


def _workers(deployments: list[dict[str, Any]]) -> Iterator[Examined]:
    """A pool to which something is deployed needs a worker whose heart beats."""
    pools = sorted({each["work_pool_name"] for each in deployments if each["work_pool_name"]})
    silent = [pool for pool in pools if not _live_workers(pool)]
    yield Examined(
        what="Prefect's workers",
        found=f"none lives of {', '.join(silent)}" if silent else f"live in {len(pools)} pools",
        remedy="Start them: `mimucal station work ID` for a station, `mimucal work` for the line."
        if silent
        else None,
    )


def _live_workers(pool: str) -> list[str]:
    workers = post(f"/work_pools/{pool}/workers/filter", {})
    return [each["name"] for each in workers if each["status"] == LIVE]


PYTHON = (3, 11)
MEMORY_BYTES = 2 << 30


def diagnose(home: Home) -> Diagnosis:
    """Looks at Python, the packages, the disk, the memory, and at what the home holds."""
    looks: tuple[Callable[[Home], Iterator[Examined]], ...] = (
        _python, _packages, _disk, _memory, _home, _rights, _catalogue, _clock, _settings,
        _alerts, _validation, _interrupted, _prefect,
    )  # fmt: skip
    return Diagnosis(examined=tuple(one for look in looks for one in look(home)))


def _python(_: Home) -> Iterator[Examined]:
    found = ".".join(map(str, sys.version_info[:3]))
    old = "mimucal needs Python 3.11 or newer: PYTHON=python3.12 make setup names another."
    yield Examined(what="Python", found=found, remedy=None if sys.version_info >= PYTHON else old)


def _packages(_: Home) -> Iterator[Examined]:
    needed = [Requirement(text) for text in requires("mimucal") or ()]
    wrong = [fault for one in needed if (fault := _wrong(one))]
    yield Examined(
        what="packages",
        found="; ".join(wrong) or f"{len(needed)} of {len(needed)} as required",
        remedy="Run make setup in mimucal's folder." if wrong else None,
    )


def _wrong(needed: Requirement) -> str | None:
    if needed.marker is not None and not needed.marker.evaluate():
        return None
    try:
        found = version(needed.name)
    except PackageNotFoundError:
        return f"{needed.name} is missing"
    return (
        None if found in needed.specifier else f"{needed.name} is {found}, not {needed.specifier}"
    )


def _disk(home: Home) -> Iterator[Examined]:
    free = free_bytes(home.path)
    yield Examined(
        what="disk of the home",
        found=f"{free / 2**30:.1f} GiB free",
        remedy=None
        if free >= FREE_BYTES
        else "Free some space, or see with `mimucal prune --before DATE` what nothing needs.",
    )


def _memory(_: Home) -> Iterator[Examined]:
    has = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    yield Examined(
        what="memory",
        found=f"{has / 2**30:.1f} GiB",
        remedy=None if has >= MEMORY_BYTES else "Long recordings need 2 GiB: use another machine.",
    )


def _home(home: Home) -> Iterator[Examined]:
    folder = next(folder for folder in (home.path, *home.path.parents) if folder.exists())
    is_good = folder.is_dir() and os.access(folder, os.W_OK | os.X_OK)
    made = "" if folder == home.path else ", made when something is stored"
    yield Examined(
        what="home",
        found=f"{home.path}{made}" if is_good else f"{folder} takes no files",
        remedy=None
        if is_good
        else "Let MIMUCAL_HOME name a folder that you may write to, or change this one's rights.",
    )


def _rights(home: Home) -> Iterator[Examined]:
    """A home that everybody on this machine may read gives away hashes of passwords."""
    if not home.path.is_dir():
        return
    rights = home.path.stat().st_mode
    is_open = bool(rights & stat.S_IRWXO)
    yield Examined(
        what="rights of the home",
        found=stat.filemode(rights),
        remedy=f"Keep everybody else out: chmod -R o= {home.path}." if is_open else None,
    )


def _catalogue(home: Home) -> Iterator[Examined]:
    try:
        count = len(runs.all_runs(home))
        broken = next(audit_trail.faults(home), None)
    except Unusable as fault:
        yield Examined(what="catalogue", found="cannot be read", remedy=str(fault))
        return
    yield Examined(
        what="catalogue",
        found=f"{count} runs" + (f"; the trail: {broken}" if broken else ""),
        remedy="See `mimucal verify`, and restore the catalogue's backup." if broken else None,
    )


def _clock(home: Home) -> Iterator[Examined]:
    """A clock that was set back gives certificates and reminders of the wrong day."""
    try:
        newest = max((entry.at for entry in audit_trail.entries(home)), default=None)
    except Unusable:
        return
    moment = datetime.now(UTC)
    is_late = newest is not None and newest > moment
    yield Examined(
        what="clock",
        found=f"{moment:%Y-%m-%d %H:%M} UTC"
        + (f", before the trail's newest entry, {newest:%Y-%m-%d %H:%M}" if is_late else ""),
        remedy="Set the computer's clock." if is_late else None,
    )


def _settings(home: Home) -> Iterator[Examined]:
    """The laboratory's own files: one that cannot be read stops what needs it."""
    looks = (
        (
            settings.LABORATORY,
            _laboratory,
            "certificates need one: deploy/guide/certificates.md",
        ),
        (settings.REMINDERS, settings.reminders, "nobody is reminded without one"),
    )
    for name, look, without in looks:
        try:
            found = look(home)
        except Unusable as fault:
            yield Examined(what=name, found="cannot be used", remedy=str(fault))
        else:
            yield Examined(what=name, found="sound" if found else f"none; {without}")


def _laboratory(home: Home) -> Laboratory | None:
    found = settings.laboratory(home)
    check_capabilities(found.capabilities if found else ())
    return found


def _alerts(home: Home) -> Iterator[Examined]:
    """A line on a Prefect server goes on unwatched; what fails there must reach somebody."""
    if not environment().prefect_server:
        return
    try:
        found = settings.reminders(home)
    except Unusable:  # which `_settings` says
        return
    operators = found.operators if found else None
    yield Examined(
        what="alerts",
        found=f"go to {', '.join(operators.channels)}" if operators else "nobody is alerted",
        remedy=None
        if operators
        else f"Name in [operators] of {home.path / settings.REMINDERS} who hears of a run that is "
        "late, crashed or invalid.",
    )


def _validation(home: Home) -> Iterator[Examined]:
    try:
        kept = settings.validation(home) or record.shipped()
    except Unusable as fault:
        yield Examined(what="validation record", found="cannot be used", remedy=str(fault))
        return
    is_current = kept is not None and record.is_current(kept)
    yield Examined(
        what="validation record",
        found="of this code" if is_current else "of another code",
        remedy=None
        if is_current
        else "No unit passes by it: run `mimucal validate`, which takes some ten minutes.",
    )


def _interrupted(home: Home) -> Iterator[Examined]:
    going_on = {
        Path(file).name
        for status, dead in statuses(home)
        if status.state not in ENDED and not dead
        for file in status.recordings
    }
    left = [
        path
        for path in sorted(home.acquiring.glob("*.mcap"))
        if path.name not in going_on and has_readings(path)  # the next run removes the others
    ]
    yield Examined(
        what="interrupted runs",
        found=", ".join(path.name for path in left) or "none",
        remedy="Go on with `mimucal acquire --resume`, or take them in with `mimucal import "
        "--salvage`." if left else None,
    )  # fmt: skip
    waiting = sorted(home.acquired.glob("*.mcap"))
    yield Examined(
        what="runs to be stored",
        found=", ".join(path.name for path in waiting) or "none",
        remedy=f"Store each with `mimucal import {home.acquired}/FILE`; the next run does, too."
        if waiting
        else None,
    )


def _prefect(_: Home) -> Iterator[Examined]:
    yield from examine_prefect()
