"""Recordings refused on import because no item could be estimated from them."""

from pathlib import Path

import numpy as np

from schemas.base import Unusable
from schemas.recording import ACCEL, ANGLE, GYRO, MEASURED, Manifest, Recording, Segment, Stream
from storage.catalogue.lineage import stated_day
from storage.formats import recordings
from storage.formats.checks import absent
from storage.formats.convert import Changes
from storage.verify import StoreFault
from tasks.motion.angle_rates import as_mean_rates
from tasks.readings.codes import codes_put_right
from tasks.readings.plausibility import implausible
from tasks.readings.stamps import with_instants
from tasks.segments.find import segments_of
from tasks.segments.summarise import summarise_all
from tasks.segments.units import wrong_accel_unit, wrong_rate_unit
from tasks.words import say


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
    fault = (
        _unreadable_moment(recording.manifest)
        or _missing_triad(recording.manifest, recording.imu)
        or _wrong_unit(recording)
    )
    if fault is not None:
        raise Unusable(f"{path}: {fault}")
    return recording


def doubts_of(recording: Recording) -> tuple[str, ...]:
    """Sentences on what a recording cannot be."""
    rates = as_mean_rates(codes_put_right(with_instants(recording)))
    return tuple(say(one.sentence, "en") for one in implausible(rates, segments_of(rates)))


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


def _wrong_unit(recording: Recording) -> str | None:
    labels = tuple(s for s in recording.manifest.segments or () if s.kind in ("rate", "static"))
    segments = summarise_all(codes_put_right(recording), labels, "label")
    return wrong_rate_unit(segments) or wrong_accel_unit(segments)


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
