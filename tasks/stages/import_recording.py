"""Stage: imports a recording into the store."""

import os
from dataclasses import dataclass
from pathlib import Path

from schemas.base import Unusable
from storage.catalogue import run_index, runs
from storage.catalogue.run_index import Run
from storage.home import Home
from tasks.stages.stage import stage


@dataclass(frozen=True)
class Imported:
    """A recording in the store: its run, whether it is new, topics of a bag left out of it."""

    run: Run
    is_new: bool
    left_out: tuple[str, ...] = ()


@stage("import")
def import_recording(
    path: Path, home: Home, *, manifest: Path | None = None, salvage: bool = False
) -> Imported:
    """Read a recording, check it, keep it.

    One that a run could not store leaves the home's `acquired` folder. Raises Unusable, with the
    store unchanged, where the recording cannot be used. `left_out` is
    empty for a recording whose bytes are in the store already, which is not read again.
    """
    known = None if manifest else runs.imported_before(path, home)
    if known is not None:
        return Imported(known, is_new=False)
    from tasks.stages import import_checks  # late: most commands name a run that is there

    recording = import_checks.read(path, manifest=manifest, salvage=salvage)
    run, is_new = runs.add(recording, home, source=None if manifest or salvage else path)
    if path.absolute().parent == home.acquired.absolute():  # it waited for this
        path.unlink(missing_ok=True)
    return Imported(run, is_new, recording.extra.get("left_out", ()))


def run_of(reference: str, home: Home) -> Run:
    """The run that an order names: an id, or a path that is imported on the fly.

    Raises Unusable for an empty one.
    """
    if not reference.strip():
        raise Unusable("RUN is empty; give a run id, as `mimucal runs` lists them, or a path.")
    if os.path.exists(reference):  # of a text that can be no path it says no; Path.exists raises
        return import_recording(Path(reference), home).run
    return run_index.find(reference, home)
