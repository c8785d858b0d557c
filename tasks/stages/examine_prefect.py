"""Whether the Prefect server that is named does what a line asks of it."""

from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from typing import Any

from schemas.doctor import Examined
from storage.environment import environment
from tasks.stages.prefect_api import NotAnswered, get, is_open, post

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
