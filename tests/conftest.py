"""What every test may use: the shared recordings, and an ideal JJF 2003 run by plain algebra."""

import fcntl
import gc
import hashlib
import logging
import os
import shutil
import signal
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from dataclasses import replace
from datetime import date
from functools import cache
from itertools import chain, groupby
from pathlib import Path

import pytest
from hypothesis import settings

from flows.logs import ROOT
from schemas.calibration import EVIDENCE, Check, ItemValidation, MethodValidation, ValidationRecord
from schemas.certificate import Certificate
from schemas.recording import Recording
from storage.catalogue import database
from storage.formats.folder import read_folder
from storage.home import Home
from tasks.certificate.dcc import record_bytes
from tasks.specifications.estimate import ITEMS
from tasks.validation.fingerprint import fingerprint
from tests import ideal
from tests.migrated import as_migrated
from tests.proof.line import Line, Recorded, draw_line, fill
from tests.shared import ABSENT, shared_path
from tests.surroundings import leave_production

settings.register_profile("unhurried", deadline=None)  # machines are busy; pytest limits tests
settings.load_profile("unhurried")

SPREAD = 0.8  # of the files, among which those that wait are laid
ENDINGS = tuple((one, signal.SIG_DFL) for one in (signal.SIGHUP, signal.SIGQUIT, signal.SIGTERM))


def pytest_configure() -> None:
    """Nothing that the environment names is touched: see tests/surroundings.py.

    Imports and collected tests live to the end: the garbage collector need not look at them. A
    shell ignores the keyboard's signals for what it starts in the background, and children inherit
    that: the tests raise them.
    """
    leave_production()
    gc.disable()
    for one, usual in ((signal.SIGINT, signal.default_int_handler), *ENDINGS):
        if signal.getsignal(one) == signal.SIG_IGN:
            signal.signal(one, usual)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """The worker that comes first compiles the tests alone; the others read what it compiled."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        return (yield)
    with Path(__file__).open() as first:
        try:
            fcntl.flock(first, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            fcntl.flock(first, fcntl.LOCK_SH)
        return (yield)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files that wait for the wall clock lie evenly among the others.

    So one worker waits while two compute: all at once they would leave the processors idle, and at
    the end, which is free of them, one worker would wait alone.
    """
    files = [list(own) for _, own in groupby(items, lambda item: item.getparent(pytest.Module))]
    others = [own for own in files if not waits(own[0].getparent(pytest.Module))]
    waiting = [own for own in files if waits(own[0].getparent(pytest.Module))]
    apart = int(SPREAD * len(others)) // max(len(waiting), 1)
    for number, own in enumerate(waiting):
        others.insert(number * (apart + 1), own)
    items[:] = chain.from_iterable(others)


def waits(file: pytest.Module | None) -> bool:
    return file is not None and file.get_closest_marker("real_time") is not None


def pytest_collection_finish() -> None:
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)  # seldom: tests leave little behind
    gc.enable()


def room_of(report: pytest.TestReport) -> str:
    return str(Path(report.nodeid.partition("::")[0]).parent)


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    """Tests that were skipped because ../shared is not beside this clone, by what they miss; of a
    rehearsal what each room has in it, which `make test` leaves out.
    """
    reasons = (report.longrepr[2] for report in terminalreporter.stats.get("skipped", ()))
    absent = Counter(reason.removeprefix("Skipped: ") for reason in reasons if ABSENT in reason)
    for reason, tests in sorted(absent.items()):
        terminalreporter.write_line(f"{tests} tests skipped: {reason}")
    if config.getoption("markexpr") != "rehearsal":
        return
    ended = [one for kind in ("passed", "failed") for one in terminalreporter.stats.get(kind, ())]
    for name, own in groupby(sorted(ended, key=room_of), room_of):
        seconds = [one.duration for one in own]
        terminalreporter.write_line(f"{name:40s} {len(seconds):5d} cases {sum(seconds):8.0f} s")


@pytest.fixture(scope="session", autouse=True)
def _as_migrated() -> Iterator[None]:
    """Homes begin with the tables of the newest revision; tests/storage judges how they get there.

    Commands in processes of their own migrate theirs.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(database, "_migrate", as_migrated)
        yield


@pytest.fixture(autouse=True)
def _events_of_one_test() -> Iterator[None]:
    """Commands and pages in this process send the events where they want, for their test alone."""
    yield
    events = logging.getLogger(ROOT)
    events.handlers.clear()
    events.setLevel(logging.NOTSET)
    events.propagate = True


@pytest.fixture
def fresh(tmp_path, monkeypatch) -> Home:
    """A home in which nothing was kept yet; its folder does not exist."""
    monkeypatch.delenv("MIMUCAL_DATABASE", raising=False)
    return Home(tmp_path / "home")


@pytest.fixture
def unprinted(monkeypatch) -> None:
    """Certificates whose PDF is not typeset, for tests of what is done with them."""

    def quick(certificate: Certificate, **_: object) -> bytes:
        return b"%PDF " + hashlib.sha256(record_bytes(certificate)).digest()

    monkeypatch.setattr("tasks.certificate.pdf.render", quick)


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of the recordings beside the project."""
    return shared_path("data")


@pytest.fixture(scope="session")
def validated() -> ValidationRecord:
    """A validation record of this very code, so that no test waits for a study to be made."""
    shown = {kind: Check(passed=True, en="shown", zh="已证明") for kind in EVIDENCE}
    items = {name: ItemValidation(checks=shown) for name in ITEMS}
    return ValidationRecord(
        made_on=date(2026, 11, 21), code_version="test", seed=1, seconds=1.0,
        methods={
            method: MethodValidation(fingerprint=fingerprint(method), items=items)
            for method in ("jjf2003", "joint", "jjf1536")
        },
    )  # fmt: skip


@pytest.fixture(scope="session")
def real() -> Callable[[str], Recording]:
    """Reads a recording of other people's hardware by its folder name."""
    return lambda name: read_folder(shared_path(f"data/real/{name}"))


@pytest.fixture(scope="session")
def plant() -> Callable[..., Recording]:
    """Reads a simulated recording by its folder name, once: nobody may change its columns.

    The second argument: every so many rows, which tell most things as well, and sooner.
    """

    @cache
    def read(name: str, every: int = 1) -> Recording:
        whole, kept = read_folder(shared_path(f"data/plant/{name}")), slice(None, None, every)
        assert whole.table is not None
        thinned = replace(whole, imu=whole.imu.at(kept), table=whole.table.at(kept))
        for stream in (thinned.imu, thinned.table):
            for column in (stream.t, *stream.columns.values()):
                column.flags.writeable = False
        return thinned

    return read


@pytest.fixture(scope="session")
def ideal_run() -> Callable[..., Recording]:
    """Builds a JJF 2003 run of a unit whose readings follow models (1) and (2) exactly."""
    return ideal.ideal_run


@pytest.fixture(scope="session")
def line_store(tmp_path_factory, worker_id) -> tuple[Home, Line]:
    """The store of a line of two units with sixty runs over three years; four have recordings.

    It is made once for all workers; each has a copy.
    """
    base = tmp_path_factory.getbasetemp()
    made = Home((base if worker_id == "master" else base.parent) / "line_store")
    home, line = Home(tmp_path_factory.mktemp("line") / "home"), draw_line(3, 60, 2)
    with made.path.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not made.path.exists():
            fill(made, line, Recorded(4), lambda done, of: None)
        shutil.copytree(made.path, home.path)
    return home, line
