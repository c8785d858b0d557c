"""Stations side by side on this computer, and one far faster: not a frame may be missing."""

import os
import resource
import socket
import struct
import tempfile
import time
import zlib
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager, suppress
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from schemas.procedure import Procedure
from storage.formats.mcap.reader import read_mcap
from storage.formats.mcap.writer import RawWriter
from tasks.station import procedures
from tasks.station.acquisition import NewRecording, RunRequest, acquire
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.servers import running
from tests.proof.study import Out, Write, hold, table

CASES = ((8, 1000.0), (1, 10_000.0))  # stations, frames in a second of each
APART_S = 3.0  # nobody starts eight stations in the same second
SLICE_S = 0.005
BODY = struct.Struct("<2sIQ6i")
LINK = {
    "frame": {
        "kind": "binary", "sync": "aa55", "check": "crc32",
        "fields": [
            {"name": "counter", "type": "uint32"},
            {"name": "time", "type": "uint64", "unit": "us"},
            *({"name": f"gyro_{axis}", "type": "int32", "scale": 1e-7} for axis in "xyz"),
            *({"name": f"accel_{axis}", "type": "int32", "scale": 1e-6} for axis in "xyz"),
        ],
    }
}  # fmt: skip
COLUMNS = ("stations", "Hz", "s", "rows", "missing", "lost or bad", "CPU, each", "MB, each", "load")
Measured = dict[str, Any]


def throughput(
    seconds: Annotated[float, typer.Argument(metavar="SECONDS", min=1)] = 600.0,
    out: Out = None, write: Write = False,
) -> None:  # fmt: skip
    """Fast stations side by side, each for so long."""
    work = {f"{seconds:g}-{stations}": (stations, rate) for stations, rate in CASES}
    hold("throughput", work, partial(side_by_side, seconds=seconds), partial(_page, seconds), out,
         write=write, at_once=0, faults=_faults)  # fmt: skip


def side_by_side(case: tuple[int, float], seconds: float) -> Measured:
    """So many acquisitions at once at a rate: the sums and the largest of their figures."""
    stations, rate_hz = case
    context = get_context("spawn")
    with ProcessPoolExecutor(stations, mp_context=context) as pool:
        each = list(pool.map(partial(_acquired, rate_hz, seconds), range(stations)))
    return {name: max(one[name] for one in each) for name in each[0]} | {
        "stations": stations, "rate_hz": rate_hz, "rows": sum(one["rows"] for one in each),
        "load": os.getloadavg()[1],
    }  # fmt: skip


def _acquired(rate_hz: float, seconds: float, number: int) -> Measured:
    """One acquisition of a rest, by a process of its own; what of it is in the file."""
    time.sleep(number * APART_S)
    values = procedures.load("jjf2003").model_dump()
    step = values["steps"][0] | {"dwell_s": seconds}
    rest = Procedure.model_validate(values | {"steps": [step], "warm_up_s": 1.0})
    with (
        tempfile.TemporaryDirectory() as folder,
        running(VirtualStation(), 1.0) as station,
        _sending(rate_hz) as port,
    ):
        link = {"url": f"socket://127.0.0.1:{port}", "rate_hz": rate_hz} | LINK
        fields = station.model_dump(mode="json") | {"unit_link": link}
        fast, raw = type(station).model_validate(fields), Path(folder) / "raw.mcap"
        before = time.process_time()
        with RawWriter(raw) as sink:
            recording = NewRecording(fast, sink, "throughput")
            (acquired,) = acquire(RunRequest(fast, rest, (recording,), lambda _: None))
        used = time.process_time() - before
        t = read_mcap(raw).imu.t
    return {
        "share": used / float(t[-1] - t[0]), "seconds": float(t[-1] - t[0]), "rows": len(t),
        "missing": int(np.rint(np.diff(t) * rate_hz - 1.0).sum()),
        "lost": acquired.lost_samples + acquired.bad_frames,
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
    }  # fmt: skip


@contextmanager
def _sending(rate_hz: float) -> Iterator[int]:
    """The port of a unit that does nothing but send, to whoever connects first."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        process = get_context("fork").Process(target=_send, args=(server, rate_hz), daemon=True)
        process.start()
        try:
            yield server.getsockname()[1]
        finally:
            process.kill()
            process.join()


def _send(server: socket.socket, rate_hz: float) -> None:
    """Frames with a counter and a CRC at an even rate, as many as are due."""
    client, _ = server.accept()
    began_s, number = time.monotonic(), 0
    with suppress(ConnectionError):  # the client has what it wanted
        while True:
            due = int((time.monotonic() - began_s) * rate_hz)
            client.sendall(b"".join(_frame(each, rate_hz) for each in range(number, due)))
            number = due
            time.sleep(SLICE_S)


def _frame(number: int, rate_hz: float) -> bytes:
    """Readings that differ from one to the next."""
    readings = ((number * 7919 + 104729 * place) % 2000 - 1000 for place in range(6))
    body = BODY.pack(b"\xaa\x55", number, round(number * 1e6 / rate_hz), *readings)
    return body + struct.pack("<I", zlib.crc32(body))


def _faults(one: Measured) -> list[str]:
    gone = one["missing"] + one["lost"]
    return [f"{gone} frames of {one['stations']} stations are missing"] if gone else []


def _page(seconds: float, found: Sequence[Measured]) -> str:
    rows = (
        (one["stations"], f"{one['rate_hz']:g}", f"{one['seconds']:.0f}", f"{one['rows']:,}",
         one["missing"], one["lost"], f"{one['share']:.0%}", f"{one['peak_mb']:.0f}",
         f"{one['load']:.1f}")
        for one in found
    )  # fmt: skip
    return "\n".join([
        "# Throughput", "",
        f'`make prove ARGS="throughput {seconds:g}"` on {os.cpu_count()} cores: acquisitions side '
        "by side, each a process with a virtual table and chamber at the clock's speed, a unit "
        "that sends, and a raw file on the disk, from which rows are read back.", "",
        *table(COLUMNS, rows), "",
    ])  # fmt: skip
