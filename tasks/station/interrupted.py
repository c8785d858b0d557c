"""An interrupted run: what can be kept, and what is left of its procedure."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import Manifest, Recording, Segment, Stream
from schemas.unit_link import UnitLink
from tasks.station.anomalies import MEASURED
from tasks.station.monitor import check_unit
from tasks.station.plan import PlannedSegment

GAP_INTERVALS = 1.5


@dataclass(frozen=True)
class Interrupted:
    """manifest: with the segments that stand. t_end: s, up to where anything was recorded."""

    manifest: Manifest
    t_end: float

    def measured(self) -> set[str]:
        """Names of the measured segments that stand."""
        return {each.name for each in self.manifest.segments or () if each.kind in MEASURED}


def interrupted(recording: Recording, link: UnitLink) -> Interrupted:
    """What stands of a run that broke off, by the data that are there.

    A measured segment whose data are not whole becomes a transition, and is to be measured again.
    """
    segments = tuple(
        segment if segment.kind not in MEASURED or _is_sound(segment, recording, link)
        else Segment(name=f"interrupted{place:03d}", kind="transition", mount=segment.mount,
                     t_start=segment.t_start, t_end=segment.t_end)
        for place, segment in enumerate(recording.manifest.segments or ())
    )  # fmt: skip
    ends = [float(stream.t[-1]) for stream in recording.streams().values() if len(stream)]
    ends += [segment.t_end for segment in segments]
    manifest = recording.manifest.model_copy(update={"segments": segments})
    return Interrupted(manifest, max(ends))


def remaining(planned: Iterable[PlannedSegment], measured: set[str]) -> Iterator[PlannedSegment]:
    """The segments that are still to be measured, in order.

    The unit is turned over again before the first of them, since the attitude in which an
    interrupted run left it is unknown.
    """
    turned_over = None
    for segment in planned:
        turned_over = segment.refix or turned_over
        if segment.name not in measured:
            yield replace(segment, refix=turned_over)
            turned_over = None


def _is_sound(segment: Segment, recording: Recording, link: UnitLink) -> bool:
    streams = (recording.imu, recording.table)
    whole = all(stream is not None and _is_whole(segment, stream) for stream in streams)
    return whole and not check_unit(segment, recording.imu, link)


def _is_whole(segment: Segment, stream: Stream) -> bool:
    """Whether a stream has no gap in a segment, and goes past its end."""
    rows = stream.rows(segment.t_start, segment.t_end)
    if rows.stop == len(stream) or rows.stop - rows.start < 2:
        return False
    steps = np.diff(stream.t[max(rows.start - 1, 0) : rows.stop + 1])
    return bool(steps.max() <= GAP_INTERVALS * np.median(np.diff(stream.t)))
