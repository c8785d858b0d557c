"""What a run with a fault left: a recording or a sentence, and a table that rests."""

import socket
import time
from dataclasses import dataclass
from urllib.parse import urlsplit

import numpy as np

from schemas.recording import Recording
from schemas.station import StationFile
from tasks.station.acquisition import Acquired
from tests.proof.kills.tap import FRAME

AT_REST = np.radians(1.0)  # rad/s that a gyro may read
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
            if np.abs(np.median(counts, axis=0)).max() * lsb < AT_REST:
                return True
    return False
