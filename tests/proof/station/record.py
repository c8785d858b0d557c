"""A recording of the virtual station, in simulated time: the procedure with short dwells."""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from schemas.procedure import Procedure
from schemas.recording import Recording, Stream
from storage.formats.mcap.reader import read_mcap
from storage.formats.mcap.writer import RawWriter
from tasks.station import procedures
from tests.proof.station.case import Case
from tests.proof.station.load import BusyStation
from tests.tasks.station.in_memory import InMemoryStation

DWELL_S, WARM_UP_S = 4.0, 5.0
SPEED = 200.0  # station seconds in a second of the simulated wall clock


def recording_of(case: Case) -> Recording:
    """Acquired by way of a raw file, as a run is; then its stamps are moved by the delay."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        with RawWriter(path) as sink:
            _station(case).acquire(shortened(case.procedure), sink)
        made = read_mcap(path)
    stamps = np.round(made.imu.t + case.delay_s, 9)
    name = f"station_{case.name}"
    manifest = made.manifest.model_copy(update={"recording_id": name})
    return replace(made, manifest=manifest, imu=Stream(stamps, made.imu.columns))


def _station(case: Case) -> InMemoryStation:
    if case.is_loaded:
        return BusyStation(case.station, SPEED, case.seed)
    return InMemoryStation(case.station, SPEED)


def shortened(name: str) -> Procedure:
    values = procedures.load(name).model_dump()
    steps = [
        step | ({"dwell_s": min(step["dwell_s"], DWELL_S)} if "dwell_s" in step else {})
        for step in values["steps"]
    ]
    return Procedure.model_validate(values | {"steps": steps, "warm_up_s": WARM_UP_S})
