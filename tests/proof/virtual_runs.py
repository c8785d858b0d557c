"""Runs of a virtual station: what its unit sends, whether its table rests, and a run in memory."""

import socket
import struct
import threading
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from urllib.parse import urlsplit

import numpy as np

from schemas.base import Unusable
from schemas.procedure import Procedure
from schemas.recording import Manifest, Recording, Stream, joined
from schemas.station import StationFile
from tasks.station import procedures
from tasks.station.acquisition import Acquired
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import StationFault
from tests.tasks.station.in_memory import InMemoryStation

SPEED_IN_MEMORY = 160.0  # times the clock
AT_REST_DEG_S = 1e-3
REST_STEPS = 60_000  # ms in which a table comes to rest, where nobody sees it
FRAME = struct.Struct("<HIQ3i3ihH")  # deploy/station.md, the frame of rates
SYNC = 0x55AA


@dataclass(frozen=True)
class Sent:
    """Frames as a unit sent them: (n,) when each was passed on (s, monotonic), its stamp (µs), and
    (n, 6) counts of gyros and accelerometers.
    """

    passed_s: np.ndarray
    stamps: np.ndarray
    counts: np.ndarray


@dataclass
class Tap:
    """Stands between a unit and one client on this machine, and logs what it passes on."""

    unit: tuple[str, int]
    _log: list[tuple[float, bytes]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._server = socket.create_server(("127.0.0.1", 0))
        self.url = f"socket://127.0.0.1:{self._server.getsockname()[1]}"
        threading.Thread(target=self._pass_on, daemon=True).start()

    def _pass_on(self) -> None:
        client, _ = self._server.accept()
        with client, socket.create_connection(self.unit) as unit:
            try:
                while data := unit.recv(65536):
                    client.sendall(data)
                    self._log.append((time.monotonic(), data))
            except OSError:
                pass  # the client was killed

    def close(self) -> None:
        """Take no further client."""
        self._server.close()

    def sent(self) -> Sent:
        """Every whole frame that was passed on."""
        log = list(self._log)
        data = b"".join(part for _, part in log)
        ends = np.cumsum([len(part) for _, part in log])
        frames = list(FRAME.iter_unpack(data[: len(data) - len(data) % FRAME.size]))
        if any(frame[0] != SYNC for frame in frames):
            raise ValueError("the unit's line does not hold frame after frame")
        last_bytes = FRAME.size * np.arange(1, len(frames) + 1)
        parts = np.searchsorted(ends, last_bytes)
        return Sent(
            np.array([log[part][0] for part in parts]),
            np.array([frame[2] for frame in frames], dtype=np.int64),
            np.array([frame[3:9] for frame in frames], dtype=np.int64).reshape(-1, 6),
        )


AT_REST_RAD_S = np.radians(1.0)  # rad/s that a gyro may read
LONGEST_S = 20.0  # wall time: ten times that of the watchdog and the ramps
LOOKED_AT = 40  # frames


@dataclass(frozen=True)
class Outcome:
    """recording: None where the run stopped, with a sentence. is_at_rest: None where not seen."""

    recording: Recording | None
    acquired: Acquired | None
    sentence: str
    is_at_rest: bool | None


def comes_to_rest(station: StationFile, lsb: float) -> bool:
    """Whether the table comes to rest soon, by the gyros of its unit, whose step is lsb (rad/s).

    The unit tells it also where the table's controller answers no more, and asking it is no sign
    of life that would keep a watchdog waiting.
    """
    unit = urlsplit(station.unit_link.url)
    end_s = time.monotonic() + LONGEST_S
    with socket.create_connection((str(unit.hostname), int(unit.port or 0)), LONGEST_S) as line:
        while time.monotonic() < end_s:
            data = b""
            while len(data) < LOOKED_AT * FRAME.size:
                data += (part := line.recv(LOOKED_AT * FRAME.size - len(data)))
                if not part:
                    return False
            counts = np.array([frame[3:6] for frame in FRAME.iter_unpack(data)])
            if np.abs(np.median(counts, axis=0)).max() * lsb < AT_REST_RAD_S:
                return True
    return False


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
    moves = np.abs(np.degrees(station.simulation.table.rate)).max() > AT_REST_DEG_S
    recording = sink.recording() if acquired else None
    return Outcome(recording, acquired, sentence, station.table.has_been_left and not moves)
