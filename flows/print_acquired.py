"""Prints the runs that were acquired."""

import sys
from typing import TYPE_CHECKING, Any

from flows.print_validity import lines, summary
from flows.printing import print_json
from storage.home import Home

if TYPE_CHECKING:
    from schemas.validity import Validity
    from storage.catalogue.run_index import Run
    from tasks.stages.acquire import AcquiredRuns
    from tasks.station.acquisition import Acquired


def print_acquired(acquired: "AcquiredRuns", home: Home, as_json: bool) -> bool:
    """Print the runs and their validity; returns whether none is invalid."""
    from tasks.stages.validity import validity_of

    judged = [(run, made, validity_of(run, home)) for run, made in acquired.kept]
    if as_json:
        first, *others = (_as_data(*each) for each in judged)
        several = {"neighbours": others, "given_up": list(acquired.given_up)}
        is_alone = not others and not acquired.given_up
        print_json({"format": "mimu-acquire/1"} | first | ({} if is_alone else several))
    else:
        for run, made, validity in judged:
            print(run.id)
            for sentence in (*(remark.en for remark in made.warnings), *lines(validity)):
                print(sentence, file=sys.stderr)
    return all(validity.verdict != "invalid" for *_, validity in judged)


def _as_data(run: "Run", made: "Acquired", validity: "Validity") -> dict[str, Any]:
    return {
        "run": run.id,
        "recording_id": run.recording_id,
        "lost_samples": made.lost_samples,
        "bad_frames": made.bad_frames,
        "warnings": [remark.en for remark in made.warnings],
        "validity": summary(validity),
    }
