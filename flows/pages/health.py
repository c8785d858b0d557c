"""`/health` and `/metrics`: whether everything that the line needs is there, and how it goes.

`/health` is open to everybody and names nothing. `/metrics` has the stations' names: it answers
this machine itself, where no proxy stands in front, and whoever gives a user's name and password
(HTTP basic authentication).
"""

import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from ipaddress import ip_address
from typing import Any

from flask import Blueprint, Response, request
from prometheus_client import CollectorRegistry, Counter, generate_latest
from prometheus_client.core import GaugeMetricFamily, InfoMetricFamily
from prometheus_client.exposition import CONTENT_TYPE_LATEST
from prometheus_client.metrics_core import Metric

from flows.pages.answers import refusal
from flows.pages.login import LoginLimiter, by_password
from schemas.base import Unusable
from storage import settings
from storage.blobs import blobs_of
from storage.catalogue import database
from storage.catalogue.dump import snapshot
from storage.catalogue.production_history import line_counts
from storage.catalogue.users import users
from storage.home import Home
from storage.stations import statuses
from tasks.version import code_version

LEAST_FREE = 2**30  # bytes: five runs of an hour
ANSWER_S = 5.0  # time allowed for each part to answer
FORWARDED = ("Forwarded", "X-Forwarded-For", "X-Forwarded-Host", "Via")  # by a proxy

Look = Callable[[Home], str | None]


def endpoints(home: Home, gate: LoginLimiter) -> Blueprint:
    """The two endpoints; requests are counted for /metrics."""
    made, registry = Blueprint("health", __name__), CollectorRegistry()
    registry.register(LineMetrics(home))
    requests = Counter(
        "mimucal_http_requests", "Requests answered, by status.", ["status"], registry=registry
    )

    @made.get("/health")
    def health() -> tuple[dict[str, Any], int]:
        faults = {name: fault for name, fault in health_checks(home).items() if fault}
        return {"ok": not faults, "faults": faults}, 503 if faults else 200

    @made.get("/metrics")
    def metrics() -> Response:
        if not _is_here(home) and not _is_user(home, gate):
            refused = refusal(401, "say who you are: HTTP basic authentication")
            refused.headers["WWW-Authenticate"] = 'Basic realm="mimucal", charset="UTF-8"'
            return refused
        return Response(generate_latest(registry), content_type=CONTENT_TYPE_LATEST)

    @made.after_app_request
    def count(response: Response) -> Response:
        requests.labels(str(response.status_code)).inc()
        return response

    return made


def _is_user(home: Home, gate: LoginLimiter) -> bool:
    try:
        return by_password(users(home), gate, home) is not None
    except Unusable:  # without the database nobody is known
        return False


def _is_here(home: Home) -> bool:
    """Whether the request comes from this machine, and from nobody behind it."""
    if settings.pages(home).proxy or any(name in request.headers for name in FORWARDED):
        return False
    return ip_address(request.remote_addr or "0.0.0.0").is_loopback


def health_checks(home: Home) -> dict[str, str | None]:
    """What is wrong with each part, None if nothing; a part that does not answer in time is wrong.

    No place, name or password is in it.
    """
    pool = ThreadPoolExecutor(len(LOOKS))
    try:
        asked = {name: pool.submit(look, home) for name, look in LOOKS.items()}
        return {name: _answer(each) for name, each in asked.items()}
    finally:
        pool.shutdown(wait=False)


def _answer(asked: Any) -> str | None:
    try:
        found: str | None = asked.result(timeout=ANSWER_S)
    except TimeoutError:
        return "does not answer"
    except (Unusable, OSError):
        return "cannot be used; see `mimucal doctor`"
    return found


def _database(home: Home) -> str | None:
    with snapshot(home):
        return None


def _migrations(home: Home) -> str | None:
    with snapshot(home) as connection:
        revision = None if connection is None else database.revision_of(connection)
    if revision in (None, database.HEAD):
        return None
    return "the catalogue is of another version; see `mimucal upgrade`"


def _store(home: Home) -> str | None:
    blobs_of(home).exists("raw/none.mcap")
    return None


def _disk(home: Home) -> str | None:
    return None if _free(home) >= LEAST_FREE else "less than 1 GiB free"


def _free(home: Home) -> int:
    there = next(folder for folder in (home.path, *home.path.parents) if folder.exists())
    return shutil.disk_usage(there).free


LOOKS: dict[str, Look] = {
    "database": _database, "migrations": _migrations, "store": _store, "disk": _disk,
}  # fmt: skip


class LineMetrics:
    """The figures of a line, found when somebody asks."""

    def __init__(self, home: Home) -> None:
        self._home = home

    def describe(self) -> list[Metric]:
        """None beforehand: finding them asks the catalogue."""
        return []

    def collect(self) -> Iterator[Metric]:
        """Everything; a catalogue that cannot be read leaves out what is in it."""
        yield InfoMetricFamily("mimucal_build", "Version.", {"version": code_version()})
        free = GaugeMetricFamily("mimucal_disk_free_bytes", "Free on the home's disk.")
        free.add_metric([], _free(self._home))
        yield free
        sound = GaugeMetricFamily(
            "mimucal_health", "1: the part is as it should be.", None, ["part"]
        )
        for part, fault in health_checks(self._home).items():
            sound.add_metric([part], 0 if fault else 1)
        yield sound
        yield from self._stations()
        try:
            yield from self._catalogue()
        except Unusable:
            return

    def _stations(self) -> Iterator[Metric]:
        state = GaugeMetricFamily(
            "mimucal_station_state", "1: the state of the station's last run.", None,
            ["station", "state"],
        )  # fmt: skip
        age = GaugeMetricFamily(
            "mimucal_station_status_age_seconds", "Since its last run wrote its status.", None,
            ["station"],
        )  # fmt: skip
        for status, is_dead in statuses(self._home):
            state.add_metric([status.station, "dead" if is_dead else status.state], 1)
            age.add_metric([status.station], _age(status.at))
        yield state
        yield age

    def _catalogue(self) -> Iterator[Metric]:
        counts = line_counts(self._home)
        for name, what, label, counted in (
            ("mimucal_runs", "Runs by the verdict on the run.", "verdict", counts.runs),
            ("mimucal_certificates", "Certificates by state.", "state", counts.certificates),
            ("mimucal_orders_waiting", "Orders that wait.", "station", counts.orders_waiting),
        ):
            family = GaugeMetricFamily(name, what, None, [label])
            for labels, count in counted.items():
                family.add_metric(labels, count)
            yield family
        failed = GaugeMetricFamily("mimucal_reminders_failed", "Not sent; the last try failed.")
        failed.add_metric([], counts.reminders_failed)
        yield failed
        last = GaugeMetricFamily("mimucal_last_run_age_seconds", "Since a run was imported.")
        if counts.last_run_at is not None:
            last.add_metric([], _age(counts.last_run_at))
        yield last


def _age(moment: datetime) -> float:
    return (datetime.now(UTC) - moment).total_seconds()
