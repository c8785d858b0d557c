"""One acquisition, measured: `python -m tests.proof.throughput.client STATION SECONDS RAW`."""

import json
import resource
import sys
from pathlib import Path

import numpy as np

from schemas.procedure import Procedure
from schemas.station import StationFile
from storage.formats.mcap.reader import read_mcap
from storage.formats.mcap.writer import RawWriter
from tasks.station import procedures
from tasks.station.acquisition import NewRecording, RunRequest, acquire


def resting(seconds: float) -> Procedure:
    """One position of JJF 2003, held for so long."""
    whole = procedures.load("jjf2003").model_dump()
    step = whole["steps"][0] | {"dwell_s": seconds}
    return Procedure.model_validate(whole | {"steps": [step], "warm_up_s": 1.0})


def main(station_file: str, seconds: float, raw: str) -> None:
    """Acquire, print what it took as JSON, then what of it is in the file."""
    station = StationFile.model_validate_json(Path(station_file).read_text(encoding="utf-8"))
    before = resource.getrusage(resource.RUSAGE_SELF)
    with RawWriter(Path(raw)) as sink:
        recording = NewRecording(station, sink, "throughput")
        request = RunRequest(station, resting(seconds), (recording,), lambda _: None)
        (acquired,) = acquire(request)
    used = resource.getrusage(resource.RUSAGE_SELF)
    t = read_mcap(Path(raw)).imu.t
    period_s = 1.0 / station.unit_link.rate_hz
    measured = {
        "cpu_s": used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime,
        "peak_mb": used.ru_maxrss / 1024.0,
        "seconds": float(t[-1] - t[0]),
        "rows": len(t),
        "missing": int(np.rint(np.diff(t) / period_s - 1.0).sum()),
        "lost": acquired.lost_samples,
        "bad": acquired.bad_frames,
        "given_up": acquired.given_up,
    }
    print(json.dumps(measured))


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), sys.argv[3])
