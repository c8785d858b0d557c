"""The status of a run, kept up to date during acquisition."""

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime

from schemas.procedure import Procedure
from schemas.run_log import ENDED, RunStatus, State
from schemas.station import StationFile
from storage.home import Home
from storage.run_status import write_status
from tasks.station.progress import Progress

WRITE_EVERY_S = 1.0


@contextmanager
def status_file(
    station: StationFile, procedure: Procedure, home: Home, report: Callable[[Progress], None]
) -> Iterator[Callable[[Progress], None]]:
    """Gives the report that also writes the status: at every change, and every WRITE_EVERY_S.

    An exception is written as the cause for which the run stopped.
    """
    began, written_s = datetime.now(UTC), 0.0
    last = Progress("connecting", 0.0, 0.0, 0.0)
    units = tuple(alone.unit.serial for alone in station.per_unit())

    def write(state: State, cause: str = "") -> None:
        nonlocal written_s
        written_s = time.monotonic()
        status = RunStatus(
            station=station.station.id, procedure=procedure.name, units=units, process=os.getpid(),
            began_at=began, at=datetime.now(UTC), state=state, now=last.now,
            segment=last.segment, segments=last.segments, station_s_done=last.station_s_done,
            station_s_total=last.station_s_total, wall_s_left=last.wall_s_left,
            rates_hz=last.rates_hz, noise=last.noise, alarms=last.alarms, cause=cause,
        )  # fmt: skip
        write_status(status, home)

    def reporting(progress: Progress) -> None:
        nonlocal last
        is_new = (progress.state, progress.now) != (last.state, last.now)
        last = progress
        if is_new or time.monotonic() - written_s >= WRITE_EVERY_S:
            # The run is done once its recording is in the store.
            write("finishing" if progress.state in ENDED else progress.state)
        report(progress)

    write("begun")
    try:
        yield reporting
    except BaseException as fault:
        write("stopped", str(fault) or type(fault).__name__)
        raise
    write("done")
