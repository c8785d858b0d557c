"""Prints one run."""

import sys
from typing import TYPE_CHECKING, Any

from pydantic import TypeAdapter, ValidationError

from flows.print_calibration import lines, print_calibration, summary
from flows.printing import print_json, print_rows, stdout
from schemas.base import Unusable, first_fault
from schemas.run_log import LogEntry
from storage.catalogue import certificates, results, runs
from storage.home import Home, home
from tasks.stages.import_recording import run_of
from tasks.stages.validity import validity_of
from tasks.words import say

if TYPE_CHECKING:
    from schemas.text import Validity
    from storage.catalogue.run_index import Run
    from tasks.stages.acquire import AcquiredRuns
    from tasks.station.acquisition import Acquired


def show_run(reference: str, as_json: bool) -> None:
    """Print a run: unit, station, validity, segments, newest results, certificates."""
    run = run_of(reference, home())
    manifest = runs.manifest(run, home())
    kept, validity = results.of_run(run, home()), validity_of(run, home())
    entries = certificates.of_run(run, home())
    if as_json:
        print_json(
            {
                "format": "mimu-run/1",
                "run": run.model_dump(mode="json"),
                "validity": summary(validity),
                "manifest": manifest.model_dump(mode="json"),
                "results": [result.model_dump(mode="json") for result in kept],
                "certificates": [entry.model_dump(mode="json") for entry in entries],
            }
        )
        return
    unit, station = manifest.unit, manifest.station
    console = stdout(markup=False)
    console.print(f"{run.id} {run.recording_id} ({run.standard})", style="bold")
    console.print(f"unit     {unit.manufacturer} {unit.model} {unit.serial}")
    console.print(f"station  {station.id}")
    console.print(
        f"length   {run.seconds:.1f} s, {run.rows} rows; imported {run.imported_at:%F %R}"
    )
    for line in lines(validity):
        console.print(line)
    if manifest.segments:
        print_rows(
            "Segments",
            ("name", "kind", "from s", "to s"),
            [(s.name, s.kind, f"{s.t_start:.2f}", f"{s.t_end:.2f}") for s in manifest.segments],
        )
    if kept:
        print_calibration(kept[-1].calibration)
    for entry in entries:
        console.print(f"certificate {entry.number}: {entry.verdict} ({entry.state}), {entry.pdf}")


def show_log(reference: str, as_json: bool) -> None:
    """Print the log of a run.

    Raises Unusable if its manifest has no log, or an invalid one.
    """
    run = run_of(reference, home())
    kept = (runs.manifest(run, home()).model_extra or {}).get("log")
    if kept is None:
        raise Unusable(f"run {run.id} has no log: no acquisition of this program recorded it")
    try:
        log = TypeAdapter(tuple[LogEntry, ...]).validate_python(kept)
    except ValidationError as error:
        raise Unusable(f"the log of run {run.id} is not understood: {first_fault(error)}") from None
    if as_json:
        entries = [entry.model_dump(mode="json") for entry in log]
        print_json({"format": "mimu-run-log/1", "run": run.id, "log": entries})
        return
    rows = [(f"{e.at:%F %T}", f"{e.t:.2f}", e.state.replace("_", " "), say(e)) for e in log]
    print_rows(f"Log of run {run.id}", ("UTC", "at s", "state", "cause"), rows)


def print_acquired(acquired: "AcquiredRuns", home: Home, as_json: bool) -> bool:
    """Print the runs and their validity; returns whether none is invalid."""
    judged = [(run, made, validity_of(run, home)) for run, made in acquired.kept]
    if as_json:
        first, *others = (_as_data(*each) for each in judged)
        several = {"neighbours": others, "given_up": list(map(str, acquired.given_up))}
        is_alone = not others and not acquired.given_up
        print_json({"format": "mimu-acquire/1"} | first | ({} if is_alone else several))
    else:
        for run, made, validity in judged:
            print(run.id)
            for sentence in (*(say(remark) for remark in made.warnings), *lines(validity)):
                print(sentence, file=sys.stderr)
    return all(validity.verdict != "invalid" for *_, validity in judged)


def _as_data(run: "Run", made: "Acquired", validity: "Validity") -> dict[str, Any]:
    return {
        "run": run.id,
        "recording_id": run.recording_id,
        "lost_samples": made.lost_samples,
        "bad_frames": made.bad_frames,
        "warnings": [say(remark) for remark in made.warnings],
        "validity": summary(validity),
    }
