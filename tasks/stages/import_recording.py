"""Stage: imports a recording into the store."""

import os
from dataclasses import dataclass
from pathlib import Path

from schemas.base import Unusable
from storage.catalogue import run_index, runs
from storage.catalogue.run_index import Run
from storage.formats import recordings
from storage.formats.convert import Changes
from storage.home import Home
from tasks.stages.stage import stage


@dataclass(frozen=True)
class Imported:
    """A recording in the store: its run, whether it is new, topics of a bag left out of it, and
    sentences on what it cannot be.
    """

    run: Run
    is_new: bool
    left_out: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()


@stage("import")
def import_recording(
    path: Path,
    home: Home,
    *,
    manifest: Path | None = None,
    salvage: bool = False,
    changes: Changes | None = None,
    by_log_time: bool = False,
) -> Imported:
    """Read a recording, check it, keep it.

    One that a run could not store leaves the home's `acquired` folder. Raises Unusable, with the
    store unchanged, where the recording cannot be used. `left_out` and `doubts` are
    empty for a recording whose bytes are in the store already, which is not read again.
    changes: of a copy's units, axes and label times. by_log_time: a bag's messages are stamped
    when they were logged.
    """
    plain = not (manifest or salvage or changes or by_log_time)
    known = runs.imported_before(path, home) if plain else None
    if known is not None:
        return Imported(known, is_new=False)
    from tasks.stages import import_checks  # late: most commands name a run that is there

    recording = recordings.read(
        path, manifest=manifest, salvage=salvage, changes=changes, by_log_time=by_log_time
    )
    sight = import_checks.sight_of_usable(path, recording)
    run, is_new = runs.add(recording, home, source=path if plain else None)
    if path.absolute().parent == home.acquired.absolute():  # it waited for this
        path.unlink(missing_ok=True)
    left_out = recording.extra.get("left_out", ())
    return Imported(run, is_new, left_out, import_checks.doubts_of(recording, sight))


def run_of(reference: str, home: Home) -> Run:
    """The run that an order names: an id, or a path that is imported on the fly.

    Raises Unusable for an empty one.
    """
    if not reference.strip():
        raise Unusable("RUN is empty; give a run id, as `mimucal runs` lists them, or a path.")
    # returns False for text that cannot be a path, where Path.exists raises
    if os.path.exists(reference):
        return import_recording(Path(reference), home).run
    return run_index.find(reference, home)
