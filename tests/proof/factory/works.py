"""The parts of the factory on this machine, each of which can be killed and started again."""

import random
import shutil
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib.resources import files
from pathlib import Path
from typing import Any

import httpx
import psycopg
from psycopg import sql

from schemas.procedure import Procedure
from tasks.station import procedures
from tests import postgres
from tests.proof.factory.draw import CLIENTS, EVERY_MONTH
from tests.proof.factory.processes import Part
from tests.proof.study import environment

STATIONS = ("HALL-A", "HALL-B")
PERSONS = {"Li Na": "operator", "Zhao Min": "verifier", "Chen Jie": "issuer"}
PASSWORD = "of-the-factory-only"
LOGIN = ("factory", PASSWORD)
AUTH = ":".join(LOGIN)
API_S = 30.0
WORKER_LOOKS_S = "2"  # for the next order, in place of ten: an order takes half a minute here
DASK_WORKERS = 2
KEYS = {"AWS_ACCESS_KEY_ID": "of-a-proof", "AWS_SECRET_ACCESS_KEY": "of-a-proof"}
PORTS = (20_000, 30_000)  # Linux gives clients 32768 and above
MIMUCAL = (sys.executable, "-P", "-m", "flows.cli")
PREFECT = (sys.executable, "-m", "prefect")
# The factory's own procedure: every clause of jjf2003, with shorter dwells than the 30 s that it
# asks for, so that no unit passes on it; it warms up for less, and moves faster.
DWELL_S, WARM_UP_S, SETTLE_S, MOVE_DEG_S, ACCELERATION_DEG_S2 = 3.0, 10.0, 0.5, 360.0, 1000.0
ORDER = """format = "mimu-order/1"
received = 2024-01-08
recalibration_agreed = true
interval_months = {months}
waived_conditions = ["largest_rate"]
[client]
name = "{name}"
name_zh = "{name}"
address = "1 Road"
address_zh = "路 1 号"
"""
OPERATORS = """
[operators]
language = "en"
[operators.channels]
e-mail = "mailto://127.0.0.1:{port}?from=lab@example.org&to=line@example.org&mode=insecure"
"""
CLIENT = """
[[clients]]
name = "{name}"
[clients.channels]
e-mail = "mailto://127.0.0.1:{port}?from=lab@example.org&to=client{number}@example.org&mode=insecure"
"""


class Works:
    """A folder, the ports, and the parts; `started` starts them all."""

    def __init__(self, folder: Path, speed: float) -> None:
        self.folder, self.speed = folder, speed
        self.home, self.logs, self.objects = (folder / name for name in ("home", "logs", "objects"))
        self.mails = folder / "mails"
        self.checkout = Path.cwd()
        folder.chmod(0o711)  # PostgreSQL is no root
        for each in (self.home, self.logs, self.objects, self.mails):
            each.mkdir(parents=True)
        stations = (name for id_ in STATIONS for name in (id_, f"unit on {id_}"))
        self.ports = _free_ports("prefect", "s3", "pages", "mail", "dask", *stations)
        self.database = _Database(folder / "postgres", self.logs)
        self.parts: dict[str, Part] = {}

    @property
    def prefect_url(self) -> str:
        return f"http://127.0.0.1:{self.ports['prefect']}/api"

    @property
    def pages_url(self) -> str:
        return f"http://127.0.0.1:{self.ports['pages']}"

    @property
    def scheduler(self) -> str:
        return f"tcp://127.0.0.1:{self.ports['dask']}"

    @property
    def store(self) -> str:
        return f"s3://lab/mimu?endpoint=127.0.0.1:{self.ports['s3']}&scheme=http&region=here"

    @property
    def variables(self) -> dict[str, str]:
        """The environment of every command of the line."""
        return environment(
            MIMUCAL_HOME=str(self.home), MIMUCAL_DATABASE=self.database.url("mimucal"),
            MIMUCAL_STORE=self.store, PREFECT_API_URL=self.prefect_url,
            PREFECT_API_AUTH_STRING=AUTH, PREFECT_HOME=str(self.folder / "prefect"),
            DO_NOT_TRACK="1", PREFECT_SERVER_ANALYTICS_ENABLED="false",
            PYTHONPATH=str(self.checkout), **KEYS,
        )  # fmt: skip

    def command(self, *words: object, given: str = "", **changes: str) -> str:
        """What a command of the line prints; raises RuntimeError with its sentence if it fails."""
        return self._run(MIMUCAL, words, given, changes)

    def python(self, code: str) -> str:
        """The same of a few lines of Python."""
        return self._run((sys.executable, "-c", code), (), "", {})

    def _run(
        self, program: Sequence[str], words: Sequence[object], given: str, changes: dict[str, str]
    ) -> str:
        done = subprocess.run(
            list(map(str, (*program, *words))), env=self.variables | changes, input=given,
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        line = " ".join(map(str, (*program[2:], *words)))
        with (self.logs / "commands.log").open("a", encoding="utf-8") as log:
            log.write(f"{line} -> {done.returncode} {done.stderr.strip()}\n")
        if done.returncode:
            raise RuntimeError(f"{line}: {done.stderr.strip()[-2000:]}")
        return done.stdout

    def station_file(self, station: str) -> Path:
        """What the station itself says of it; `mimucal station add` takes it in."""
        return self.folder / f"{station}.json"

    def station(self, id_: str, serial: str, seed: int, faults: Sequence[str] = ()) -> Part:
        """A station with the unit of that seed on its table, which says that it is that serial."""
        port, file = self.ports[id_], self.station_file(id_)
        command = (
            sys.executable, "-m", "tests.proof.factory.servers", "station", port, id_, serial,
            seed, self.speed, file, *faults,
        )  # fmt: skip
        return self._part(id_, command, lambda: file.exists() and listens(port + 1))

    def start(self) -> None:
        """Everything but the deployments and their workers."""
        self.database.start()
        self.database.create("mimucal", "prefect", "restored")
        s3 = (sys.executable, "-m", "tests.proof.factory.servers", "s3")
        sink = (*s3[:-1], "mail")
        parts = [
            self._part(
                "S3", (*s3, self.ports["s3"], self.objects), lambda: listens(self.ports["s3"])
            ),
            self._part(
                "mail sink", (*sink, self.ports["mail"], self.mails),
                lambda: listens(self.ports["mail"]),
            ),
            self._part(
                "Prefect server", (*PREFECT, "server", "start", "--port", self.ports["prefect"]),
                self._prefect_answers,
                PREFECT_SERVER_DATABASE_CONNECTION_URL=self.database.url("prefect", "+asyncpg"),
                PREFECT_SERVER_API_AUTH_STRING=AUTH,
                PREFECT_SERVER_CONCURRENCY_LEASE_STORAGE=(
                    "prefect.server.concurrency.lease_storage.filesystem"
                ),
            ),
            self._part(
                "dask scheduler",
                (sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", self.scheduler,
                 "--no-dashboard"),
                lambda: listens(self.ports["dask"]),
            ),
        ]  # fmt: skip
        self._write_papers()
        parts += [self.station(id_, "none", seed) for seed, id_ in enumerate(STATIONS)]
        parts += [
            self._part(f"dask worker {number + 1}", (
                sys.executable, "-m", "distributed.cli.dask_worker", self.scheduler, "--nthreads",
                1, "--no-nanny", "--no-dashboard", "--death-timeout", 60, "--preload",
                "tasks.stages.reprocess",
            )) for number in range(DASK_WORKERS)
        ]  # fmt: skip
        for part in parts:
            part.begin()
        for part in parts:
            part.wait()
        for person, role in PERSONS.items():
            self.command("user", "add", person, "--role", role, "--by", "Founder", given=PASSWORD)
        self._part(
            "pages", (*MIMUCAL, "dashboard", "--port", self.ports["pages"]), self._pages_answer
        ).start()

    def deploy(self) -> None:
        """The line's deployments and those of each station, as the guide says."""
        self.command("deploy", "--timezone", "Asia/Shanghai")
        for id_ in STATIONS:
            self.command("station", "add", self.station_file(id_), "--timezone", "Asia/Shanghai")

    def start_workers(self) -> None:
        """A worker for the line, and one for each station."""
        commands: dict[str, tuple[object, ...]] = {
            "line": (*MIMUCAL, "work"),
            **{f"station-{id_}": (*MIMUCAL, "station", "work", id_) for id_ in STATIONS},
        }
        for pool, command in commands.items():
            self._part(
                f"worker {pool}", command, is_service=True,
                PREFECT_WORKER_QUERY_SECONDS=WORKER_LOOKS_S,
            ).begin()  # fmt: skip

    def keep_up(self, away: str | None) -> None:
        """What the service manager does for the parts, but for one that is killed just now."""
        for name, part in self.parts.items():
            if name != away:
                part.keep_up()

    def _part(
        self, name: str, command: Sequence[object], answers: Callable[[], bool] = lambda: True,
        *, is_service: bool = False, **changes: str,
    ) -> Part:  # fmt: skip
        part = Part(name, command, self.variables | changes, self.logs, answers, is_service)
        if name in self.parts:
            part.processor_s = self.parts[name].processor_s
        self.parts[name] = part
        return part

    def prefect_api(self, method: str, path: str, **asked: Any) -> Any:
        """What Prefect's server answers; raises HTTPError where it does not, or refuses."""
        answer = httpx.request(
            method, f"{self.prefect_url}{path}", auth=LOGIN, trust_env=False, timeout=API_S, **asked
        )
        return answer.raise_for_status().json()

    def _prefect_answers(self) -> bool:
        with suppress(httpx.HTTPError):
            return bool(self.prefect_api("GET", "/health"))
        return False

    def _pages_answer(self) -> bool:
        with suppress(httpx.HTTPError):
            return httpx.get(f"{self.pages_url}/login", trust_env=False).status_code == 200
        return False

    def _write_papers(self) -> None:
        papers = files("flows") / "demo_papers"
        (self.home / "tolerances").mkdir()
        (self.home / "client-orders").mkdir()
        laboratory = (papers / "laboratory.toml").read_text(encoding="utf-8")
        (self.home / "laboratory.toml").write_text(laboratory, encoding="utf-8")
        shutil.copy(str(papers / "tolerance.toml"), self.home / "tolerances")
        recall = [OPERATORS.format(port=self.ports["mail"])]
        recall += [
            CLIENT.format(name=name, port=self.ports["mail"], number=number)
            for number, name in enumerate(CLIENTS)
        ]
        (self.home / "recall.toml").write_text("".join(recall), encoding="utf-8")
        for name in CLIENTS:
            text = ORDER.format(name=name, months=1 if name == EVERY_MONTH else 12)
            self.client_order(name).write_text(text, encoding="utf-8")
        self.procedure.write_text(_own_procedure().model_dump_json(indent=1), encoding="utf-8")

    def order_by_schedule(self, station: str) -> None:
        """What the clock gives: a run of the deployment that names no order."""
        (found,) = self.prefect_api(
            "POST", "/deployments/filter", json={"deployments": {"name": {"any_": [station]}}}
        )
        order = {"order": {**(found["parameters"].get("order") or {}), "station": station}}
        self.prefect_api(
            "POST", f"/deployments/{found['id']}/create_flow_run", json={"parameters": order}
        )

    @property
    def orders(self) -> Path:
        """The orders as the CSV that a manufacturing system would write."""
        return self.folder / "orders.csv"

    def client_order(self, client: str) -> Path:
        return self.home / "client-orders" / f"{client.split()[0].lower()}.toml"

    def procedure_of(self, name: str) -> object:
        """What an order says for a procedure of `draw`."""
        return self.procedure if name == "factory" else name

    @property
    def procedure(self) -> Path:
        """The file of the factory's own procedure."""
        return self.home / "jjf2003_factory.json"

    def end(self) -> None:
        """Everything, the database last."""
        for part in reversed(self.parts.values()):
            part.end()
        self.database.end()


class _Database:
    """PostgreSQL, as a part."""

    def __init__(self, folder: Path, logs: Path) -> None:
        folder.mkdir(parents=True)
        self.folder, self._logs = folder, logs
        self._server: postgres.Server | None = None

    def start(self) -> None:
        if self._server is None:
            self._server = postgres.Server(self.folder)
        else:
            self._server.start()

    def kill(self) -> None:
        assert self._server is not None
        self._server.kill()

    def end(self) -> None:
        if self._server is not None:
            self._server.stop()

    @contextmanager
    def connected(self, name: str) -> Iterator[psycopg.Connection]:
        with psycopg.connect(f"host={self.folder} user=lab dbname={name}", autocommit=True) as made:
            yield made

    def create(self, *names: str) -> None:
        with self.connected("postgres") as connection:
            for name in names:
                connection.execute(sql.SQL("CREATE DATABASE {}").format(sql.Identifier(name)))

    def url(self, name: str, driver: str = "") -> str:
        return f"postgresql{driver}://lab@/{name}?host={self.folder}"


def _own_procedure() -> Procedure:
    shipped = procedures.load("jjf2003")
    steps = tuple(step.model_copy(update={"dwell_s": DWELL_S}) for step in shipped.steps)
    return shipped.model_copy(
        update={
            "name": "jjf2003_factory", "warm_up_s": WARM_UP_S, "settle_s": SETTLE_S,
            "move_rate_deg_s": MOVE_DEG_S, "acceleration_deg_s2": ACCELERATION_DEG_S2,
            "steps": steps,
        }
    )  # fmt: skip


def listens(port: int) -> bool:
    with suppress(OSError), socket.create_connection(("127.0.0.1", port), 1.0):
        return True
    return False


def _free_ports(*names: str) -> dict[str, int]:
    """A free port for each; that of a unit follows that of its station.

    Below those that the system gives to clients: while a part is dead none of them takes its port.
    """
    while True:
        first = random.randint(*PORTS)
        ports = range(first, first + len(names))
        try:
            taken = [socket.create_server(("127.0.0.1", port)) for port in ports]
        except (OSError, OverflowError):
            continue
        for each in taken:
            each.close()
        return dict(zip(names, ports, strict=True))
