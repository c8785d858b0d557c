"""What every test may use: the shared recordings, and an ideal JJF 2003 run by plain algebra."""

import fcntl
import gc
import hashlib
import os
import shutil
import signal
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import settings

from schemas.certificate import Certificate
from schemas.recording import ACCEL, GYRO, Manifest, Recording, Stream
from schemas.validation import (
    EVIDENCE,
    Check,
    ItemValidation,
    MethodValidation,
    ValidationRecord,
)
from storage.catalogue import database
from storage.formats.folder import read_folder
from storage.home import Home
from tasks.certificate.dcc import record_of
from tasks.specifications.items import ITEMS
from tasks.validation.fingerprint import fingerprint
from tests.migrated import as_migrated
from tests.proof.line.draw import Line, draw_line
from tests.proof.line.recorded import Recorded
from tests.proof.line.store import fill
from tests.shared import ABSENT, shared_path
from tests.surroundings import leave_production

settings.register_profile("unhurried", deadline=None)  # machines are busy; pytest limits tests
settings.load_profile("unhurried")

GRAVITY = 9.78
AXES = "xyz"
RATES = (-300.0, -200.0, -100.0, -50.0, -10.0, 10.0, 50.0, 100.0, 200.0, 300.0)

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
    """Files that wait for the wall clock come first: at the end one worker would wait alone."""
    items.sort(key=lambda item: not waits(item.getparent(pytest.Module)))


def waits(file: pytest.Module | None) -> bool:
    return file is not None and file.get_closest_marker("real_time") is not None


def pytest_collection_finish() -> None:
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)  # seldom: tests leave little behind
    gc.enable()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Tests that were skipped because ../shared is not beside this clone, by what they miss."""
    reasons = (report.longrepr[2] for report in terminalreporter.stats.get("skipped", ()))
    absent = Counter(reason.removeprefix("Skipped: ") for reason in reasons if ABSENT in reason)
    for reason, tests in sorted(absent.items()):
        terminalreporter.write_line(f"{tests} tests skipped: {reason}")


@pytest.fixture(scope="session", autouse=True)
def _as_migrated() -> Iterator[None]:
    """Homes begin with the tables of the newest revision; tests/storage judges how they get there.

    Commands in processes of their own migrate theirs.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(database, "_migrate", as_migrated)
        yield


@pytest.fixture
def unprinted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Certificates whose PDF is not typeset, for tests of what is done with them."""

    def quick(certificate: Certificate, **_: object) -> bytes:
        return b"%PDF " + hashlib.sha256(record_of(certificate)).digest()

    monkeypatch.setattr("tasks.certificate.documents.render", quick)


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
def plant() -> Callable[[str], Recording]:
    """Reads a simulated recording by its folder name."""
    return lambda name: read_folder(shared_path(f"data/plant/{name}"))


def unit_errors(**changes: Any) -> dict[str, np.ndarray]:
    """An ideal unit's K, B, G, Ka, Ba, P, with the named ones replaced."""
    ideal = {
        "Kg": np.eye(3), "Bg": np.zeros(3), "G": np.zeros((3, 3)),
        "Ka": np.eye(3), "Ba": np.zeros(3), "P": np.zeros((3, 3)),
    }  # fmt: skip
    return ideal | changes


def _stretch(rate: np.ndarray, force: np.ndarray, unit: dict[str, np.ndarray]) -> np.ndarray:
    """Six constant readings of models (1) and (2), written out row by row."""
    gyro = unit["Kg"] @ rate + unit["Bg"] + unit["G"] @ force
    accel = unit["Ka"] @ force + unit["Ba"] + unit["P"] @ rate**2
    return np.concatenate([gyro, accel])


@pytest.fixture(scope="session")
def ideal_run() -> Callable[..., Recording]:
    """Builds a JJF 2003 run of a unit whose readings follow models (1) and (2) exactly.

    Thirty seconds at 10 Hz a point, eleven levels within ±1e-9 so that nothing stands still.
    """

    def build(
        dwell: float = 30.0, noise: float = 1e-9, gravity: float = GRAVITY, **changes: Any
    ) -> Recording:
        unit, rate_hz = unit_errors(**changes), 10.0
        rows, segments, t = [], [], 0.0
        count = round(dwell * rate_hz)
        flip = noise * ((7 * np.arange(count) % 11) - 5.0)[:, None] / 5.0

        def hold(label: dict[str, Any], rate: np.ndarray, force: np.ndarray) -> None:
            nonlocal t
            rows.append(_stretch(rate, force, unit) + flip)
            segments.append({**label, "t_start": t, "t_end": t + dwell})
            t = round(t + dwell, 6)

        for i in range(3):
            for sign, mark in ((1, "+"), (-1, "-")):
                up = np.eye(3)[i] * sign
                for turn in (0, 180):
                    label = {
                        "name": f"position_{mark}{AXES[i]}_{turn:03d}",
                        "kind": "static",
                        "item": "twelve_position",
                        "up": mark + AXES[i],
                        "turn_deg": turn,
                    }
                    hold(label, np.zeros(3), up * gravity)
        for j in range(3):
            up = np.eye(3)[j]
            rest = {"kind": "static", "item": "rate_sensitivity", "up": "+" + AXES[j]}
            hold({"name": f"rest_{AXES[j]}", **rest}, np.zeros(3), up * gravity)
            for rate in RATES:
                label = {
                    "name": f"rate_{AXES[j]}_{rate:+.0f}",
                    "kind": "rate",
                    "axis": AXES[j],
                    "item": "scale_factor",
                    "up": "+" + AXES[j],
                    "rate_deg_s": rate,
                }
                hold(label, up * np.radians(rate), up * gravity)
            hold({"name": f"rest2_{AXES[j]}", **rest}, np.zeros(3), up * gravity)
        values = np.concatenate(rows)
        manifest = Manifest.model_validate({
            "format": "mimu-recording/1", "recording_id": "ideal", "standard": "JJF 2003-2022",
            "unit": {"manufacturer": "test", "model": "ideal", "serial": "1"},
            "station": {"id": "test", "latitude_deg": 0.0, "gravity_m_s2": gravity},
            "segments": segments,
        })  # fmt: skip
        columns = dict(zip(GYRO + ACCEL, values.T.copy(), strict=True))
        columns["temperature"] = np.full(len(values), 28.0)
        times = np.round(np.arange(len(values)) / rate_hz, 9)
        air = np.arange(0.0, t, 1.0)
        room = {"temperature": 20.0, "humidity": 50.0, "supply_voltage": 5.0}
        environment = Stream(air, {name: np.full(len(air), value) for name, value in room.items()})
        return Recording(manifest, Stream(times, columns), environment=environment, digest="0" * 64)

    return build


@pytest.fixture(scope="session")
def line_store(tmp_path_factory: pytest.TempPathFactory, worker_id: str) -> tuple[Home, Line]:
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
