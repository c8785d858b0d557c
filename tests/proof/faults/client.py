"""Runs whose own computer fails: its disk is slow or stands, or it is killed and goes on later."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest.mock import patch

from schemas.base import BrokenOff, Unusable
from schemas.procedure import Procedure
from schemas.station import StationFile
from storage.catalogue import runs
from storage.catalogue.run_index import Run
from storage.formats.mcap.chunk_writer import ChunkWriter
from storage.home import Home
from tasks.stages.acquire import acquire_run
from tasks.station.acquisition import Acquired
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import StationFault
from tasks.station.virtual.process import running
from tests.proof.faults.outcome import Outcome, comes_to_rest
from tests.proof.kills.go_on import SPEED, killed_and_resumed
from tests.tasks.station.over_sockets import ignore

FLUSHES_S = {"slow_disk": 1.5, "standing_disk": 12.0}  # wall time
OF_THE_CLIENT = {
    "slow_disk": f"each flush to the disk takes {FLUSHES_S['slow_disk']:g} s",
    "standing_disk": f"each flush to the disk takes {FLUSHES_S['standing_disk']:g} s",
    "client_killed": "the acquisition is killed, and goes on with `--resume`",
}


def run_of_client(fault: StationFault, procedure: Procedure, config: VirtualStation) -> Outcome:
    """A run, as `acquire` carries it out, with a fault of OF_THE_CLIENT."""
    with TemporaryDirectory() as folder, running(config, SPEED) as station:
        home = Home(Path(folder))
        recording, acquired, sentence = None, None, ""
        try:
            run, acquired = _acquired(fault, station, procedure, home)
            recording = runs.load(run, home)
        except (Unusable, BrokenOff) as stop:
            sentence = str(stop)
        is_at_rest = comes_to_rest(station, config.unit.gyro.lsb)
    return Outcome(recording, acquired, sentence, is_at_rest)


def _acquired(
    fault: StationFault, station: StationFile, procedure: Procedure, home: Home
) -> tuple[Run, Acquired]:
    after_s = fault.at_seconds / SPEED
    if fault.name == "client_killed":
        return killed_and_resumed(station, procedure, home, after_s)[:2]
    with _flushing(FLUSHES_S[fault.name], after_s):
        (kept,) = acquire_run(station, procedure, home, ignore).kept
    return kept


@contextmanager
def _flushing(takes_s: float, after_s: float) -> Iterator[None]:
    """A disk whose flushes take so long, from so many seconds after the block's beginning."""
    began_s, flush = time.monotonic(), ChunkWriter.flush

    def slowly(writer: ChunkWriter) -> None:
        if time.monotonic() - began_s > after_s:
            time.sleep(takes_s)
        flush(writer)

    with patch.object(ChunkWriter, "flush", slowly):
        yield
