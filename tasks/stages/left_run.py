"""Interrupted runs of a station, its units and a procedure."""

import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from schemas.base import Unusable
from schemas.procedure import Procedure
from schemas.recording import Manifest, Recording
from schemas.station import StationFile
from storage.formats.mcap.reader import NothingWhole, has_readings, read_mcap
from storage.home import Home
from storage.station_lock import statuses

EMPTY_S = 600.0  # by then every run has homed its table, and written its first readings


@dataclass(frozen=True)
class LeftRun:
    """An interrupted run: what is whole of it, and its files: attempts to go on leave more."""

    recording: Recording
    paths: tuple[Path, ...]

    def forget(self) -> None:
        """Its content is now complete in another file."""
        for path in self.paths:
            path.unlink(missing_ok=True)


def left_runs(station: StationFile, procedure: Procedure, home: Home) -> dict[str, LeftRun]:
    """The last one of each unit on this station by this procedure, by the unit's serial.

    A unit without one is not in it. Raises Unusable where none has one.
    """
    known = dict(_known(home))
    found = {}
    for alone in station.per_unit():
        if left := _last_of(alone, procedure, known):
            found[alone.unit.serial] = left
    if not found:
        raise Unusable(
            f"{home.acquiring} has no interrupted run of unit {station.unit.serial} by procedure "
            f"{procedure.name} on station {station.station.id}: start a run without --resume"
        )
    return found


def _last_of(
    station: StationFile, procedure: Procedure, known: dict[Path, tuple[Manifest, Recording | None]]
) -> LeftRun | None:
    left = {
        path: (_began(manifest), recording)
        for path, (manifest, recording) in known.items()
        if _is_of(manifest, station, procedure)
    }
    read = [(began, recording) for began, recording in left.values() if recording is not None]
    if not read:
        return None
    last, longest = max(read, key=lambda each: (each[0], each[1].imu.t[-1]))
    return LeftRun(longest, tuple(path for path, (began, _) in left.items() if began == last))


def _known(home: Home) -> Iterator[tuple[Path, tuple[Manifest, Recording | None]]]:
    """What each file says; no recording of one that was killed before its first readings."""
    for path in sorted(home.acquiring.glob("*.mcap")):
        try:
            recording = read_mcap(path, salvage=True)
        except NothingWhole as fault:
            yield path, (fault.manifest, None)
        except Unusable:
            continue
        else:
            yield path, (recording.manifest, recording)


def _is_of(manifest: Manifest, station: StationFile, procedure: Procedure) -> bool:
    fields = manifest.model_extra or {}
    return (
        (manifest.unit, manifest.station, manifest.mount)
        == (station.unit, station.station, station.mount)
        and fields.get("procedure") == procedure.name
        and "station_time_origin_s" in fields
    )


def _began(manifest: Manifest) -> str:
    return str((manifest.model_extra or {})["recorded_at"])


def forget_empty(home: Home) -> None:
    """Remove files of runs that were killed before their first readings."""
    written = {path for status, is_dead in statuses(home) if not is_dead
               for path in status.recordings}  # fmt: skip
    for path in home.acquiring.glob("*.mcap"):
        with suppress(OSError):
            left = path.stat()
            is_old = time.time() - left.st_mtime > EMPTY_S
            if is_old and str(path) not in written and not has_readings(path):
                path.unlink()
