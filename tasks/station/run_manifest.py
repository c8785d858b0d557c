"""The manifest of a run as it grows: its segments, and the entries on station and unit."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from typing import Any, Literal

import numpy as np

from schemas.procedure import Procedure, Refix
from schemas.recording import MEASURED, Manifest, Mount, Recording, Segment, Stream
from schemas.station import StationFile
from schemas.unit_link import UnitLink
from tasks.station.monitor import check_unit
from tasks.station.plan import PlannedSegment, mount_in

GAP_INTERVALS = 1.5
PERSONS = "; "  # between those who carried out the parts of a run
NOT_OF_THE_FRAMES = {"url", "baudrate", "load", "identify"}


@dataclass(frozen=True)
class Interrupted:
    """manifest: with the segments that stand. t_end: s, up to where anything was recorded."""

    manifest: Manifest
    t_end: float

    def measured(self) -> set[str]:
        """Names of the measured segments that stand."""
        return {each.name for each in self.manifest.segments or () if each.kind in MEASURED}


class ManifestBuilder:
    """Segments without gaps between them, from the beginning of the run on.

    `segments` are in station time; the manifest and the streams of the recording count from
    `origin_s`, the whole second of station time in which the run began; `acquired_at` is its UTC,
    by this computer's clock when `t_start`, a station time just read, was current. Every segment
    carries `mount`, if the unit was turned over in its fixture. earlier: an interrupted run that is
    continued: its segments and its time are the beginning of this one's. operator: who carries it
    out; of a run that goes on, with who began it.
    """

    def __init__(
        self,
        station: StationFile,
        procedure: Procedure,
        recording_id: str,
        t_start: float,
        earlier: Interrupted | None = None,
        operator: str | None = None,
    ) -> None:
        now = datetime.now(UTC)
        self.origin_s = math.floor(t_start)
        self.segments: list[Segment] = []
        self.mount: Mount | None = None
        self.extra: dict[str, Any] = {
            "procedure": procedure.name,
            "recorded_at": now.astimezone().isoformat(timespec="seconds"),
            "acquired_at": (now - timedelta(seconds=t_start - self.origin_s)).isoformat(),
            "equipment": [item.model_dump(mode="json") for item in station.equipment],
            "unit_link": station.unit_link.model_dump(mode="json", exclude=NOT_OF_THE_FRAMES),
        }
        if operator:
            self.extra["operator"] = operator
        self._station = station
        self._procedure = procedure
        self._recording_id = recording_id
        self._until = t_start
        self._nothing_until_s = 0.0  # since origin_s
        commanded = getattr(station.table, "commanded_rate", None)
        self._rates = {"commanded_rate": commanded.model_dump(mode="json")} if commanded else {}
        if earlier is not None:
            self._go_on(earlier, t_start)
        self.extra["station_time_origin_s"] = self.origin_s

    def _go_on(self, earlier: Interrupted, t_start: float) -> None:
        """Begin with what an interrupted run has; a station that was restarted has a new time."""
        before = dict(earlier.manifest.model_extra or {})
        origin_s, end_s = int(before["station_time_origin_s"]), earlier.t_end
        has_restarted = t_start - origin_s <= end_s
        self.origin_s = self.origin_s - math.ceil(end_s) - 1 if has_restarted else origin_s
        self._nothing_until_s = end_s
        self.segments = [
            _moved(segment, self.origin_s) for segment in earlier.manifest.segments or ()
        ]
        first = {"recorded_at": before["recorded_at"], "t_start": 0.0}
        present = {"recorded_at": self.extra["recorded_at"], "t_start": t_start - self.origin_s}
        self.extra["parts"] = [*before.get("parts", [first]), present]
        persons = [before.get("operator"), self.extra.get("operator")]
        if named := list(dict.fromkeys(filter(None, persons))):
            self.extra["operator"] = PERSONS.join(named)
        for name in ("recorded_at", "acquired_at", "log", "station_remarks", "table_time"):
            if name in before:
                self.extra[name] = before[name]
        self._until = end_s + self.origin_s
        self.fill("interrupted", "transition", t_start)

    def polled_within(self, half_width_s: float) -> None:
        """The angles of the table are polled, at times known to ± half_width_s, s."""
        before = self.extra.get("table_time", {}).get("half_width_s", 0.0)
        within_s = max(before, math.ceil(half_width_s * 1e6) / 1e6)
        polled = {"encoder": "polled", "half_width_s": within_s}
        self.extra["table_time"] = polled | self._rates

    def fill(self, name: str, kind: Literal["settle", "transition"], t_end: float) -> None:
        """Label what lies between the last segment and a time (s)."""
        if t_end > self._until:
            numbered = f"{name}{len(self.segments):03d}"
            self.add(Segment(name=numbered, kind=kind, t_start=self._until, t_end=t_end))

    def add(self, segment: Segment) -> None:
        self.segments.append(segment.model_copy(update={"mount": self.mount}))
        self._until = segment.t_end

    def withdraw(self, name: str) -> Segment:
        """Make a transition of a measured segment that is to be repeated; what it was."""
        place = next(i for i, each in enumerate(self.segments) if each.name == name)
        segment = self.segments[place]
        self.segments[place] = Segment(
            name=f"withdrawn{place:03d}",
            kind="transition",
            t_start=segment.t_start,
            t_end=segment.t_end,
            mount=segment.mount,
        )
        return segment

    def turned_over(self, refix: Refix | None) -> None:
        """The unit's attitude on the table from now on; not known while it is turned (None)."""
        self.mount = None if refix is None else mount_in(refix.mount, self._station.mount)

    @property
    def serial(self) -> str:
        return self._station.unit.serial

    def build(self) -> Manifest:
        """The manifest with the segments finished so far."""
        return Manifest(
            format="mimu-recording/1",
            recording_id=self._recording_id,
            standard=self._procedure.standard,
            unit=self._station.unit,
            station=self._station.station,
            mount=self._station.mount,
            segments=tuple(map(self._since_start, self.segments)),
            **self.extra,
        )

    def since_start(self, stream: Stream) -> Stream:
        """A stream over station time on the recording's time base, without rows from before the
        run.

        Rows no later than the end of an interrupted run that is continued are dropped as well.
        """
        moved = Stream(np.round(stream.t - self.origin_s, 9), stream.columns)
        until_s = self._nothing_until_s
        return moved.at(moved.t > until_s if until_s else moved.t >= 0.0)

    def _since_start(self, segment: Segment) -> Segment:
        return _moved(segment, -self.origin_s)


def _moved(segment: Segment, by_s: float) -> Segment:
    moved = {name: round(getattr(segment, name) + by_s, 9) for name in ("t_start", "t_end")}
    return segment.model_copy(update=moved)


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
