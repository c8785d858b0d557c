"""JJF 1536 in simulated time on the virtual single-axis station: procedures, runs, truth."""

import json
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from schemas.procedure import Procedure
from schemas.recording import Mount, Recording
from schemas.station import StationFile
from storage.formats.mcap.reader import read_mcap
from storage.formats.mcap.writer import RawWriter
from tasks.calibrate.calibrate import calibrate
from tasks.specifications.jjf1536 import JJF1536
from tasks.station import procedures
from tasks.station.acquisition import Acquired
from tasks.station.virtual.config import VirtualStation, station_file, truth, virtual_station
from tasks.station.virtual.faults import StationFault
from tests.tasks.station.in_memory import InMemoryStation

AXES = "xyz"


def shortened(name: str, seconds: float, **changes: Any) -> Procedure:
    """A procedure of the program with every dwell this short, and a short warm-up."""
    values = procedures.load(name).model_dump()
    steps = [
        step | ({"dwell_s": min(step["dwell_s"], seconds)} if "dwell_s" in step else {})
        for step in values["steps"]
    ]
    return Procedure.model_validate(values | {"steps": steps, "warm_up_s": 5.0} | changes)


def settled() -> VirtualStation:
    """A station whose unit does not change while it warms up, which here is not waited for."""
    station = virtual_station(3, ahrs=True)
    calm = {"bias_per_kelvin": (0.0, 0.0, 0.0)}
    gyro = station.unit.gyro.model_copy(update=calm)
    return station.model_copy(update={"unit": station.unit.model_copy(update={"gyro": gyro})})


def bench(fixture: Any, mount: Mount | None = None) -> StationFile:
    """The station file of a single-axis table that nobody listens for."""
    file = station_file(virtual_station(1, ahrs=True), 1.0, "nowhere", 502, 1)
    return file.model_copy(update={"fixture": fixture, "mount": mount or Mount()})


@dataclass(frozen=True)
class Run:
    acquired: Acquired
    recording: Recording
    truth: dict[str, Any]


def run_of(folder: Any, procedure: Procedure, faults: tuple[StationFault, ...] = ()) -> Run:
    """A run by way of a raw file, as the line makes it."""
    path, config = folder / "run.mcap", settled()
    with RawWriter(path) as sink:
        acquired = InMemoryStation(config, speed=200.0, faults=faults).acquire(procedure, sink)
    true = json.loads(json.dumps(truth(config)))
    return Run(acquired, replace(read_mcap(path), digest="0" * 64), true)


def errors(run: Run) -> dict[str, dict[str, tuple[float, float]]]:
    """(value − truth, u) of every element that has a value, by item and element."""
    result = calibrate(JJF1536, run.recording, run="r", code_version="test")
    true = {
        "ahrs_scale_factor": dict(zip(AXES, run.truth["K"], strict=True)),
        "ahrs_zero_offset": dict(zip(AXES, run.truth["B_deg_s"], strict=True)),
        "ahrs_misalignment": {
            AXES[i] + AXES[j]: np.degrees(run.truth["L"][i][j]) for i in range(3) for j in range(3)
        },
    }
    return {
        name: {
            element: (value - true[name][element], item.u[element])
            for element, value in item.value.items()
            if value is not None
        }
        for name, item in result.items.items()
    }


def part(*names: str) -> Procedure:
    """Some of the steps of JJF 1536, short."""
    whole = shortened("jjf1536", 10.0)
    steps = tuple(step for step in whole.steps if step.name in names)
    return whole.model_copy(update={"steps": steps})
