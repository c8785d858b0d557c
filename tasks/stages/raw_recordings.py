"""The raw files of a run in progress: one in the home folder for each unit."""

import secrets
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from schemas.procedure import Procedure
from schemas.station import StationFile
from storage.formats.mcap.writer import RawWriter
from storage.home import Home
from storage.whole_files import writing_in_home
from tasks.stages.left_run import LeftRun
from tasks.station.acquisition import NewRecording
from tasks.station.interrupted import interrupted


@dataclass(frozen=True)
class RawRecording:
    """A raw file that is being written, and the interrupted run it continues."""

    new: NewRecording
    sink: RawWriter
    path: Path
    left: LeftRun | None

    def take_over(self) -> None:
        """Begin the file with what an interrupted run recorded."""
        if self.left is None or self.new.earlier is None:
            return
        self.sink.manifest(self.new.earlier.manifest)
        for name, stream in self.left.recording.streams().items():
            self.sink.append(name, stream)

    def forget(self) -> None:
        """The file holds all of what the interrupted run left."""
        if self.left is not None:
            self.left.forget()


def begun(
    station: StationFile, procedure: Procedure, home: Home, left: LeftRun | None
) -> RawRecording:
    """A new file for the unit of a station; raises Unusable where the home takes none."""
    began = datetime.now(UTC)
    recording_id = f"{station.unit.serial}-{procedure.name}-{began:%Y%m%dT%H%M%SZ}"
    earlier = None
    if left is not None:
        recording_id = left.recording.manifest.recording_id
        earlier = interrupted(left.recording, station.unit_link)
    path = home.acquiring / f"{began:%Y%m%dT%H%M%SZ}-{secrets.token_hex(4)}.mcap"
    with writing_in_home(path):
        sink = RawWriter(path)
    return RawRecording(NewRecording(station, sink, recording_id, earlier), sink, path, left)


def what_is_left(recordings: Iterable[RawRecording]) -> str:
    """What a run that broke off leaves behind, as the end of a sentence; else nothing.

    A file without a reading of the unit is removed.
    """
    paths = []
    for raw in recordings:
        if raw.sink.readings:
            paths.append(str(raw.path))
        else:
            raw.path.unlink(missing_ok=True)
    if not paths:
        return ""
    it = "it" if len(paths) == 1 else "them"
    return (
        f"; recorded so far: {', '.join(paths)} (`mimucal acquire --resume` goes on with {it}, "
        f"`mimucal import --salvage` takes {it} in as {'it is' if it == 'it' else 'they are'})"
    )
