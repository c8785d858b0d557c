"""Stage: imports a recording into the store."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from schemas.base import Unusable
from schemas.recording import ACCEL, ANGLE, GYRO, MEASURED, Manifest, Recording, Segment, Stream
from schemas.text import Remark
from storage.catalogue import runs
from storage.catalogue.runs import Run, stated_day
from storage.formats import recordings
from storage.formats.convert import Changes
from storage.formats.manifest import absent
from storage.home import Home
from storage.verify import StoreFault
from tasks.readings.axes import segment_means
from tasks.readings.codes import codes_put_right
from tasks.readings.plausibility import on_sight
from tasks.readings.stamps import with_instants
from tasks.segments.find import segments_of, shown_instead
from tasks.stages.stage import stage
from tasks.words import argument, say


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

    recording = recordings.read(
        path, manifest=manifest, salvage=salvage, changes=changes, by_log_time=by_log_time
    )
    sight = sight_of_usable(path, recording)
    run, is_new = runs.add(recording, home, source=path if plain else None)
    if path.absolute().parent == home.acquired.absolute():  # it waited for this
        path.unlink(missing_ok=True)
    left_out = recording.extra.get("left_out", ())
    return Imported(run, is_new, left_out, doubts_of(recording, sight))


def run_of(reference: str, home: Home) -> Run:
    """The run that an order names: an id, or a path that is imported on the fly.

    Raises Unusable for an empty one.
    """
    if not reference.strip():
        raise Unusable("RUN is empty; give a run id, as `mimucal runs` lists them, or a path.")
    # returns False for text that cannot be a path, where Path.exists raises
    if os.path.exists(reference):
        return import_recording(Path(reference), home).run
    return runs.find(reference, home)


# Recordings refused on import because no item could be estimated from them.

MIXED_UP = ("deg/s", "57.2958rad/s", "g")  # of columns in rad/s and m/s²: nothing is estimated
LISTED = 5  # positions named in one sentence
OnSight = tuple[Recording, tuple[Remark, ...]]  # put right, with rates; all that is found of it


def read(
    path: Path,
    *,
    manifest: Path | None = None,
    salvage: bool = False,
    changes: Changes | None = None,
    by_log_time: bool = False,
) -> Recording:
    """Reads a recording to be imported, with other units, axes and label times where `changes` says
    so; raises Unusable for one of no use.

    What is stored already is never judged again.
    """
    recording = recordings.read(
        path, manifest=manifest, salvage=salvage, by_log_time=by_log_time, changes=changes
    )
    sight_of_usable(path, recording)
    return recording


def sight_of_usable(path: Path, recording: Recording) -> OnSight | None:
    """What was found of a recording on sight, None where it has no labels and nothing was looked
    for; raises Unusable for one of no use.
    """
    fault = _unreadable_moment(recording.manifest)
    fault = fault or _missing_triad(recording.manifest, recording.imu)
    sight = None if fault or not recording.manifest.segments else _on_sight(recording)
    fault = fault or (_wrong_unit(sight[1]) if sight else None)
    if fault is not None:
        raise Unusable(f"{path}: {fault}")
    return sight


def doubts_of(recording: Recording, sight: OnSight | None) -> tuple[str, ...]:
    """Sentences on what a recording cannot be."""
    rates, found = sight or _on_sight(recording)
    return (*map(say, found), *label_doubts(rates, found))


def label_doubts(recording: Recording, found: Sequence[Remark]) -> tuple[str, ...]:
    """Sentences on labels that share rows, and on positions that gravity contradicts where nothing
    that was found wrong with the whole recording may be why.
    """
    contradicted = (
        () if any(one.run == "invalid" for one in found) else _contradicted_positions(recording)
    )
    return (*contradicted, *_overlapping_labels(recording))


def _overlapping_labels(recording: Recording) -> tuple[str, ...]:
    """A sentence that names the labels which share more than one row with the one before."""
    labels = sorted(
        (s for s in recording.manifest.segments or () if s.kind in MEASURED),
        key=lambda label: label.t_start,
    )
    shared = [
        f"{first.name} and {second.name} ({first.t_end - second.t_start:.2f} s)"
        for first, second in pairwise(labels)
        if _rows_shared(recording.imu, first, second) > 1
    ]
    if not shared:
        return ()
    more = f" and {len(shared) - LISTED} more pairs" if len(shared) > LISTED else ""
    return (f"Labels overlap: {', '.join(shared[:LISTED])}{more}; correct their times.",)


def _rows_shared(imu: Stream, first: Segment, second: Segment) -> int:
    rows = imu.rows(max(first.t_start, second.t_start), min(first.t_end, second.t_end))
    return max(rows.stop - rows.start, 0)


def _contradicted_positions(recording: Recording) -> tuple[str, ...]:
    """A sentence that names the labelled positions in which gravity shows another axis up."""
    rests = [s for s in recording.manifest.segments or () if s.kind == "static" and s.up]
    means = segment_means(recording, rests).accel
    wrong = [
        f"{rest.name} (labelled {rest.up} up; gravity shows {shown})"
        for rest, read in zip(rests, means, strict=True)
        if (shown := shown_instead(rest, read)) is not None
    ]
    if not wrong:
        return ()
    more = f" and {len(wrong) - LISTED} more" if len(wrong) > LISTED else ""
    return (
        f"Gravity contradicts {len(wrong)} of {len(rests)} labelled positions: "
        f"{', '.join(wrong[:LISTED])}{more}; correct their labels, or how the unit lay.",
    )


def faults_of(path: Path) -> list[StoreFault]:
    """Reads one recording, folder or MCAP, as an import would; gives its faults."""
    try:
        read(path)
    except Unusable as error:
        return [StoreFault(what=str(path), why=str(error))]
    return []


def _unreadable_moment(manifest: Manifest) -> str | None:
    """A sentence where a day of the recording is stated that a recall could not find it by."""
    for name in ("recorded_at", "acquired_at"):
        stated = (manifest.model_extra or {}).get(name)
        if stated is not None and stated_day(stated) is None:
            return (
                f"{name} in the manifest is {stated!r}, which is no moment of ISO 8601; write it "
                "as 2026-03-04T08:00:00Z, or leave it out."
            )
    return None


def _on_sight(recording: Recording) -> OnSight:
    from tasks.motion.encoders import as_mean_rates  # late: signal filters take a while to load

    right = as_mean_rates(codes_put_right(with_instants(recording)))
    return right, (*right.put_right, *on_sight(right, segments_of(right)))


def _wrong_unit(found: Sequence[Remark]) -> str | None:
    """A sentence where rates, forces or labels are in another of the units mixed up most."""
    for one in found:
        if one.code == "label_unit" or argument(one, "unit") in MIXED_UP:
            return say(one)
    return None


def _missing_triad(manifest: Manifest, imu: Stream) -> str | None:
    """A sentence where no segment of an item has the triad that the item is measured with.

    Rates and turns need the gyro (or an AHRS's angle), rests any triad, rate sensitivity the
    accelerometer. An item counts as served when one of its segments is, and segments outside
    the data do not count: a recording that was cut off stays usable.
    """
    has = {"gyro_*": ~absent(imu, GYRO), "accel_*": ~absent(imu, ACCEL)}
    if ANGLE[0] in imu.columns:
        has["angle_*"] = np.ones(len(imu), dtype=bool)
    labelled = [s for s in manifest.segments or () if s.item and s.kind in MEASURED]
    for item in dict.fromkeys(s.item for s in labelled):
        segments, serving = _triads_needed(
            item, [s for s in labelled if s.item == item], tuple(has)
        )
        rows = [imu.rows(segment.t_start, segment.t_end) for segment in segments]
        rows = [part for part in rows if part.start < part.stop]
        if rows and not any(has[name][part].any() for name in serving for part in rows):
            return (
                f"Item {item} cannot be measured: {' and '.join(serving)} are null in all of its "
                f"{len(rows)} segments; record them there, or remove the item's label."
            )
    return None


def _triads_needed(
    item: str | None, segments: list[Segment], triads: tuple[str, ...]
) -> tuple[list[Segment], list[str]]:
    """The segments an item is measured in, and the triads of which one must be there."""
    moving = [segment for segment in segments if segment.kind != "static"]
    if item == "rate_sensitivity":
        return segments, ["accel_*"]
    if moving:
        return moving, [name for name in triads if name != "accel_*"]
    return segments, list(triads)
