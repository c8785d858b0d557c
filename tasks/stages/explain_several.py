"""Stage: which physics several recordings of one unit show together."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from schemas.base import Unusable
from schemas.discrepancy import Discrepancy
from schemas.orders import ExplainOrder
from schemas.recording import ANGLE, Recording
from storage.catalogue import runs
from storage.catalogue.run_index import Run
from storage.home import Home
from tasks.explain.correction.consequences import Consequences
from tasks.explain.explain import explain
from tasks.explain.locate.where import locate
from tasks.explain.progress import Progress, report_progress, silent
from tasks.explain.report import discrepancy_of
from tasks.review.pool import pooled
from tasks.review.run_statistics import statistics_of
from tasks.review.several_recordings import found_together, reviewed_runs
from tasks.review.several_recordings_report import discrepancy_together, held_out_gain
from tasks.stages.explain import Explained
from tasks.stages.stage import stage

if TYPE_CHECKING:
    from tasks.explain.explanation import Explanation


@stage("explain-together")
def explain_together(
    which: Sequence[Run], home: Home, order: ExplainOrder, progress: Progress = silent
) -> Explained:
    """Add up what recordings of one unit say, and name what they show together; what each says by
    itself stands among the remarks.

    Raises Unusable for recordings of different units or formats, the same one twice, and an order
    of a report, a calibration or a simulation.
    """
    # Late: the other stages need none of it.
    recordings = [runs.load(run, home) for run in which]
    _refuse(which, recordings, order)
    unit = recordings[0].manifest.unit
    who = reviewed_runs(
        {run.id: each.manifest for run, each in zip(which, recordings, strict=True)}
    )
    # In the order asked for, in which the answer names them.
    pool = pooled([
        (replace(who[run.id], at=f"{number:06d}"), statistics_of(each))
        for number, (run, each) in enumerate(zip(which, recordings, strict=True))
    ])  # fmt: skip
    found, p_value = found_together(pool)
    alone = [_answer(explain(each, progress=progress)) for each in recordings]
    report_progress(progress, "report")
    fitted = alone
    while found:
        names = list(dict.fromkeys(one.effect.name for one in found))
        fitted = [_answer(explain(each, only=names)) for each in recordings]
        gained = tuple(one for one in found if held_out_gain(one, fitted) > 0.0)
        if gained == found:
            break
        found, fitted = gained, alone
    title = f"{unit.manufacturer} {unit.model} {unit.serial}"
    return Explained(discrepancy_together(title, found, p_value, alone, fitted))


def _answer(explanation: "Explanation") -> Discrepancy:
    """Without what it does to a certificate, which is of one recording."""
    wheres = locate(explanation) if explanation.findings else ()
    none = ((),) * len(explanation.findings)
    return discrepancy_of(explanation, wheres, Consequences(none, none))


def _refuse(which: Sequence[Run], recordings: Sequence[Recording], order: ExplainOrder) -> None:
    names = ", ".join(run.recording_id for run in which)
    if len({run.id for run in which}) < len(which):
        raise Unusable(f"{names}: one of these recordings is named twice; name each once.")
    units = {
        f"{m.unit.manufacturer} {m.unit.model} {m.unit.serial}"
        for m in (each.manifest for each in recordings)
    }
    if len(units) > 1:
        raise Unusable(
            f"{names} are recordings of different units ({', '.join(sorted(units))}): explain "
            "recordings of one unit together, or `mimucal review` those of many."
        )
    if len({_format(each) for each in recordings}) > 1:
        raise Unusable(
            f"{names} have different formats (rates or angles, motion from the table or from a "
            "pose): explain those of one format together."
        )
    if order.out or order.calibration or order.simulated:
        raise Unusable(
            f"{names}: several recordings are compared with the fitted model and have no report "
            "folder; leave --out, --calibration and --simulated out, or explain one recording."
        )


def _format(recording: Recording) -> tuple[str, bool, bool]:
    angles = any(name in recording.imu.columns for name in ANGLE)
    return recording.manifest.format, angles, recording.table is None
