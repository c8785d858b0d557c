"""One run on a virtual station with a fault: how it ended, and what it left."""

from dataclasses import dataclass, field

import numpy as np

from schemas.base import Unusable
from schemas.procedure import Procedure
from schemas.recording import Manifest, Recording, Stream, joined
from tasks.station import procedures
from tasks.station.acquisition import Acquired
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import StationFault
from tasks.station.virtual.process import running
from tests.tasks.station.in_memory import InMemoryStation
from tests.tasks.station.over_sockets import over_sockets, table_and_watchdog

SPEED = 40.0
DWELL_S, DWELL_OVER_SOCKETS_S = 31.0, 3.0  # those of the specification, and real seconds
AT_REST = 1e-3  # deg/s
REST_STEPS = 60_000  # ms in which it comes to rest, where nobody sees it
# Faults of the links and of the station's computer, which a run in this process has not.
OVER_SOCKETS = frozenset({
    "modbus_silent", "modbus_exception", "modbus_address", "modbus_busy", "modbus_zeros",
    "modbus_ones", "modbus_slow", "modbus_very_slow", "modbus_cut", "modbus_cut_often",
    "chamber_silent", "chamber_frozen", "busy_computer", "power_cut", "unit_cut",
})  # fmt: skip
UNREACHABLE = frozenset({"modbus_silent", "modbus_exception", "modbus_address", "modbus_busy",
                         "modbus_zeros", "modbus_ones", "power_cut"})  # fmt: skip


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


@dataclass(frozen=True)
class Outcome:
    """recording: None where the run stopped, with a sentence. is_at_rest: None where not seen."""

    recording: Recording | None
    acquired: Acquired | None
    sentence: str
    is_at_rest: bool | None


def short_procedure(dwell_s: float) -> Procedure:
    """Six positions and two rates each way about every axis, a dwell (s) each."""
    values = procedures.load("jjf2003").model_dump()
    steps = [step | {"dwell_s": dwell_s} for step in values["steps"] if step["kind"] == "position"]
    runs = [
        step | {"dwell_s": dwell_s, "rates_deg_s": (-100, -50, 50, 100)}
        for step in values["steps"]
        if step["kind"] == "rate_run"
    ]
    ups = {step["up"]: step for step in reversed(steps)}
    axes = {step["axis"]: step for step in reversed(runs)}
    values |= {"steps": (*ups.values(), *axes.values()), "warm_up_s": 1.0}
    return Procedure.model_validate(values)


def run_with(fault: StationFault | None, config: VirtualStation) -> Outcome:
    """A run with a fault, or with none."""
    faults = [] if fault is None else [fault]
    if fault is not None and fault.name in OVER_SOCKETS:
        return _over_sockets(fault, config)
    station, sink = InMemoryStation(config, SPEED, faults), Sink()
    try:
        acquired, sentence = station.acquire(short_procedure(DWELL_S), sink), ""
    except Unusable as stop:
        acquired, sentence = None, str(stop)
    station.simulation.condition = type(station.simulation.condition)()
    station.simulation.table.hunting_rad = 0.0
    station.simulation.table.advance(REST_STEPS)
    moves = np.abs(np.degrees(station.simulation.table.rate)).max() > AT_REST
    recording = sink.recording() if acquired else None
    return Outcome(recording, acquired, sentence, station.table.has_been_left and not moves)


def _over_sockets(fault: StationFault, config: VirtualStation) -> Outcome:
    with running(config, SPEED, [fault]) as station:
        sink = Sink()
        try:
            acquired, sentence = (
                over_sockets(station, short_procedure(DWELL_OVER_SOCKETS_S), sink),
                "",
            )
        except Unusable as stop:
            acquired, sentence = None, str(stop)
        at_rest = None
        if fault.name not in UNREACHABLE:
            state, _ = table_and_watchdog(station)
            at_rest = max(abs(axis.rate_deg_s) for axis in state.axes) < AT_REST
    return Outcome(sink.recording() if acquired else None, acquired, sentence, at_rest)
