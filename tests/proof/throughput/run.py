"""Stations side by side on this computer, and one far faster."""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.process import running
from tests.proof.report import publish
from tests.proof.throughput.sender import LINK

APART_S = 3.0  # nobody starts eight stations in the same second
CASES = ((8, 1000.0), (1, 10_000.0))  # stations, frames in a second of each
HEAD = (
    "stations", "Hz", "s", "rows", "missing", "bad", "CPU of a core, each", "peak MB, each", "load",
)  # fmt: skip
TEXT = """# Throughput

`make prove ARGS="--throughput {seconds:g}"` on {cores} cores: acquisitions side by side, each a
process with a virtual table and chamber at the clock's speed, a unit that sends, and a raw file on
the disk. Rows are read back from the file; none may be missing between the first and the last.
Processor time is the acquisition's own; the stations and senders beside it, and whatever else the
computer did meanwhile, take the rest. Load: the computer's average of five minutes at the end.

| {head} |
|{rule}
{rows}
"""


@dataclass(frozen=True)
class Acquisitions:
    """So many stations at a rate, the measured figures of each, and the computer's load."""

    stations: int
    rate_hz: float
    each: tuple[dict[str, float], ...]
    load: float

    def most(self, name: str) -> float:
        """The largest of a figure."""
        return max(one[name] for one in self.each)

    @property
    def holds(self) -> bool:
        """Whether not a frame is missing, and all the time is there."""
        return self.most("missing") == self.most("lost") == self.most("bad") == 0

    def __str__(self) -> str:
        share = max(one["cpu_s"] / one["seconds"] for one in self.each)
        rows = sum(one["rows"] for one in self.each)
        return (
            f"| {self.stations} | {self.rate_hz:g} | {self.most('seconds'):.0f} | {rows:,} | "
            f"{self.most('missing'):.0f} | {self.most('bad'):.0f} | {share:.0%} | "
            f"{self.most('peak_mb'):.0f} | {self.load:.1f} |"
        )


def run_all(stations: int, rate_hz: float, seconds: float) -> Acquisitions:
    """So many acquisitions at once."""
    with tempfile.TemporaryDirectory() as name, ThreadPoolExecutor(stations) as pool:
        folders = [Path(name) / str(number) for number in range(stations)]
        each = pool.map(
            lambda number: _acquired(folders[number], number * APART_S, rate_hz, seconds),
            range(stations),
        )
        return Acquisitions(stations, rate_hz, tuple(each), os.getloadavg()[1])


def _acquired(folder: Path, after_s: float, rate_hz: float, seconds: float) -> dict[str, float]:
    folder.mkdir()
    time.sleep(after_s)
    with ExitStack() as beside:
        station = beside.enter_context(running(VirtualStation(), 1.0))
        port = beside.enter_context(_sending(rate_hz))
        link = {"url": f"socket://127.0.0.1:{port}", "rate_hz": rate_hz} | LINK
        fields = station.model_dump(mode="json") | {"unit_link": link}
        (folder / "station.json").write_text(json.dumps(fields), encoding="utf-8")
        arguments = [folder / "station.json", seconds, folder / "raw.mcap"]
        client = [sys.executable, "-m", "tests.proof.throughput.client", *map(str, arguments)]
        done = subprocess.run(client, check=True, stdout=subprocess.PIPE, text=True)
    measured: dict[str, float] = json.loads(done.stdout)
    return measured


@contextmanager
def _sending(rate_hz: float) -> Iterator[int]:
    """The port of a unit that sends to whoever connects first."""
    command = [sys.executable, "-m", "tests.proof.throughput.sender", str(rate_hz)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            yield int(process.stdout.readline())
        finally:
            process.stdin.close()


def run_throughput(seconds: float, write: bool) -> None:
    """Hold CASES and print the page; exit 1 where a frame is missing."""
    found = [run_all(stations, rate_hz, seconds) for stations, rate_hz in CASES]
    page = TEXT.format(
        seconds=seconds, cores=os.cpu_count(), head=" | ".join(HEAD), rule="---:|" * len(HEAD),
        rows="\n".join(map(str, found)),
    )  # fmt: skip
    publish("throughput.md", page, write, not all(one.holds for one in found))
