"""Whole runs from a station file with the unit on another line than the virtual station's."""

import os
import pty
import random
import socket
import threading
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest

from schemas.station import StationFile
from tasks.station.virtual.config import VirtualStation
from tests.proof.fuzz import KINDS, Kind
from tests.tasks.station.over_sockets import MEASURED, SPEED, over_sockets, serving

pytestmark = pytest.mark.real_time
RATE_HZ, SLICE_S = 100.0, 0.01
BIG_ENDIAN, TEXT = KINDS[1], KINDS[3]
Write = Callable[[bytes], object]


def reading(number: int) -> tuple[int, ...]:
    rng = random.Random(number)
    return (number, round(number * 1e6 / RATE_HZ), *(rng.randrange(-3, 4) for _ in range(6)))


@contextmanager
def sending(kind: Kind, write: Write) -> Iterator[None]:
    """A unit that sends at RATE_HZ of station time, until the block ends."""
    done = threading.Event()

    def send() -> None:
        began_s, number = time.monotonic(), 0
        with suppress(OSError):  # who listened has hung up
            while not done.is_set():
                due = int((time.monotonic() - began_s) * SPEED * RATE_HZ)
                write(b"".join(kind.made(reading(each)) for each in range(number, due)))
                number = due
                time.sleep(SLICE_S)

    thread = threading.Thread(target=send, daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


@contextmanager
def over_tcp(kind: Kind, _: Path) -> Iterator[str]:
    with socket.create_server(("127.0.0.1", 0)) as server:
        clients: list[socket.socket] = []
        threading.Thread(target=lambda: clients.append(server.accept()[0]), daemon=True).start()

        def write(data: bytes) -> None:
            if clients:
                clients[0].sendall(data)

        try:
            with sending(kind, write):
                yield f"socket://127.0.0.1:{server.getsockname()[1]}"
        finally:
            for client in clients:
                client.close()


@contextmanager
def over_serial(kind: Kind, _: Path) -> Iterator[str]:
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    try:
        with sending(kind, lambda data: os.write(ours, data)):
            yield os.ttyname(theirs)
            os.set_blocking(ours, False)  # nobody reads on: the sender must not wait for it
    finally:
        os.close(ours)
        os.close(theirs)


@contextmanager
def through_a_file(kind: Kind, folder: Path) -> Iterator[str]:
    with (folder / "unit.log").open("wb", buffering=0) as file, sending(kind, file.write):
        yield f"file://{folder / 'unit.log'}"


@pytest.mark.parametrize(
    ("line", "kind"),
    [
        pytest.param(over_tcp, BIG_ENDIAN, marks=pytest.mark.rehearsal),
        (over_serial, TEXT),
        (through_a_file, BIG_ENDIAN),
    ],
    ids=["big-endian frames over TCP", "lines of text over a serial line", "a growing file"],
)  # fmt: skip
def test_a_run_has_every_reading_that_the_unit_sent(line, kind, short, kept, tmp_path):
    with serving(VirtualStation(), SPEED) as virtual, line(kind, tmp_path) as url:
        link = {"url": url, "rate_hz": RATE_HZ, "frame": kind.frame.model_dump(mode="json")}
        station = StationFile.model_validate(virtual.model_dump() | {"unit_link": link})
        acquired = over_sockets(station, short, kept)
    assert (acquired.bad_frames, acquired.lost_samples) == (0, 0)
    assert kept.measured() == MEASURED
    imu = kept.stream("imu")
    assert np.diff(imu.t) == pytest.approx(1.0 / RATE_HZ, abs=1e-9)
    channels = [f"{triad}_{axis}" for triad in ("gyro", "accel") for axis in "xyz"]
    readings = imu.stack(tuple(channels))
    first = next(n for n in range(100_000) if (readings[:8] == sent(n, 8)).all())
    assert (readings == sent(first, len(readings))).all()


def sent(first: int, count: int) -> np.ndarray:
    return np.array([reading(number)[2:] for number in range(first, first + count)], float)
