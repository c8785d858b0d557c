"""One run on a virtual station with a fault: how it ended, and what it left."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from schemas.base import Unusable
from schemas.procedure import Procedure
from schemas.recording import Manifest, Recording, Stream, joined
from tasks.station import procedures
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import StationFault
from tasks.station.virtual.process import running
from tests.proof.faults.client import OF_THE_CLIENT, run_of_client
from tests.proof.faults.outcome import Outcome, comes_to_rest
from tests.tasks.station.in_memory import InMemoryStation
from tests.tasks.station.over_sockets import over_sockets

SPEED, SPEED_IN_MEMORY = 100.0, 160.0  # times the clock
SLOW_ANSWERS = {"modbus_slow": 10.0}  # at which an answer is late by 2 s of the station's time
DWELL_S = 31.0  # what the specification asks, and a little more
AT_REST = 1e-3  # deg/s
REST_STEPS = 60_000  # ms in which it comes to rest, where nobody sees it
# Faults of the links and of the station's computer, which a run in this process has not.
OVER_SOCKETS = frozenset({
    "modbus_silent", "modbus_exception", "modbus_address", "modbus_busy", "modbus_zeros",
    "modbus_ones", "modbus_slow", "modbus_very_slow", "modbus_cut", "modbus_cut_often",
    "chamber_silent", "chamber_frozen", "busy_computer", "power_cut", "unit_cut",
})  # fmt: skip
IN_REAL_TIME = OVER_SOCKETS | OF_THE_CLIENT.keys()
UNSEEN = ("power_cut", "unit_cut")  # the unit does not tell any more whether the table turns


@dataclass
class Sink:
    """What was recorded, and the manifest as it is known."""

    pieces: dict[str, list[Stream]] = field(default_factory=dict)
    known: Manifest | None = None

    def append(self, name: str, stream: Stream) -> None:
        self.pieces.setdefault(name, []).append(stream)

    def manifest(self, manifest: Manifest) -> None:
        self.known = manifest

    def recording(self) -> Recording:
        assert self.known is not None
        streams = {name: joined(pieces) for name, pieces in self.pieces.items()}
        return Recording(
            self.known, streams["imu"], streams.get("table"), None, streams.get("environment")
        )


def short_procedure(dwell_s: float, axes: str = "xyz", warm_up_s: float = 1.0) -> Procedure:
    """Six positions and two rates each way about the axes, a dwell (s) each."""
    values = procedures.load("jjf2003").model_dump()
    steps = [step | {"dwell_s": dwell_s} for step in values["steps"] if step["kind"] == "position"]
    runs = [
        step | {"dwell_s": dwell_s, "rates_deg_s": (-100, -50, 50, 100)}
        for step in values["steps"]
        if step["kind"] == "rate_run"
    ]
    ups = {step["up"]: step for step in reversed(steps)}
    turns = {step["axis"]: step for step in reversed(runs) if step["axis"] in axes}
    values |= {"steps": (*ups.values(), *turns.values()), "warm_up_s": warm_up_s}
    return Procedure.model_validate(values)


def procedure_of(name: str) -> Procedure:
    """That of runs with a fault: in real time a briefer one."""
    return short_procedure(DWELL_S, "x" if name in IN_REAL_TIME else "xyz")


def run_with(fault: StationFault, config: VirtualStation) -> Outcome:
    """A run with a fault."""
    if fault.name in OF_THE_CLIENT:
        return run_of_client(fault, procedure_of(fault.name), config)
    if fault.name in OVER_SOCKETS:
        return _over_sockets(fault, config)
    return run_in_memory(procedure_of(fault.name), config, [fault])


def run_in_memory(
    procedure: Procedure, config: VirtualStation, faults: Iterable[StationFault] = ()
) -> Outcome:
    """A run in this process and in simulated time."""
    station, sink = InMemoryStation(config, SPEED_IN_MEMORY, faults), Sink()
    try:
        acquired, sentence = station.acquire(procedure, sink), ""
    except Unusable as stop:
        acquired, sentence = None, str(stop)
    station.simulation.condition = type(station.simulation.condition)()
    station.simulation.table.hunting_rad = 0.0
    station.simulation.table.advance(REST_STEPS)
    moves = np.abs(np.degrees(station.simulation.table.rate)).max() > AT_REST
    recording = sink.recording() if acquired else None
    return Outcome(recording, acquired, sentence, station.table.has_been_left and not moves)


def _over_sockets(fault: StationFault, config: VirtualStation) -> Outcome:
    with running(config, SLOW_ANSWERS.get(fault.name, SPEED), [fault]) as station:
        sink = Sink()
        try:
            acquired, sentence = over_sockets(station, procedure_of(fault.name), sink), ""
        except Unusable as stop:
            acquired, sentence = None, str(stop)
        at_rest = None if fault.name in UNSEEN else comes_to_rest(station, config.unit.gyro.lsb)
    return Outcome(sink.recording() if acquired else None, acquired, sentence, at_rest)
