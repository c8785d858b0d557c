"""Stage: reads a logger's table with its protocol, shows what it understood, and keeps it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import TypeAdapter

from schemas.base import Unusable
from schemas.recording import ACCEL, AXES, GYRO, SEEN, UPS, Recording, Segment, Station, Unit
from schemas.text import Remark, Seen
from storage import settings
from storage.catalogue import runs
from storage.formats.convert import Changes, axis_map
from storage.formats.logger.read import Understood, read_log
from storage.home import Home
from storage.whole_files import writing_in_home
from tasks.readings.axes import steady_turns
from tasks.readings.codes import codes_put_right
from tasks.readings.plausibility import on_sight
from tasks.readings.rows import Break, across_breaks
from tasks.readings.stamps import with_instants
from tasks.rendering import GREY, draw, envelope, time_axis
from tasks.run_validity.site import normal_gravity
from tasks.segments.find import find_segments
from tasks.stages.import_recording import Imported, label_doubts
from tasks.stages.stage import stage
from tasks.words import MAIN

if TYPE_CHECKING:
    from matplotlib.figure import Figure


WIDTH, HEIGHT = 1000.0, 520.0  # px
BINS = 2000
COLOURS = ("#0072b2", "#d55e00", "#009e73")  # x, y, z
NO_COMMANDED_RATE = (
    "how well does the table hold a commanded rate? Nobody says: scale factors will have no U "
    "unless the laboratory states its limit of rate; or give --commanded-rate"
)
SHADES = {"static": "#e4e4e4", "rate": "#fde3c8", "rotation": "#dcead8"}


@dataclass(frozen=True)
class LogShown:
    """What was understood of a logger's table, before it is kept.

    proposed: whether segments were found instead of stated. doubts: what the recording cannot be.
    picture: the file that shows it.
    """

    understood: Understood
    proposed: bool
    doubts: tuple[Remark, ...]
    notes: tuple[str, ...]
    picture: Path

    @property
    def segments(self) -> tuple[Segment, ...]:
        return self.understood.recording.manifest.segments or ()


def mapping_like(reference: str, home: Home) -> dict[str, Any]:
    """The mapping of an earlier import, with its station and unit; Unusable for a run without."""
    manifest = runs.manifest(runs.find(reference, home), home)
    imported = (manifest.model_extra or {}).get("imported")
    if not isinstance(imported, Mapping):
        raise Unusable(
            f"--like {reference}: that run was not imported with a mapping; name another."
        )
    return {**imported, "station": manifest.station, "unit": manifest.unit}


def changes_like(like: Mapping[str, Any], own: Changes) -> Changes:
    """What an import changes where it is like another: its own goes before."""
    axes = own.axes or (axis_map(str(like["axes"])) if like.get("axes") else None)
    return replace(own, units={**like.get("units", {}), **own.units}, axes=axes)


def understand(
    path: Path,
    home: Home,
    *,
    protocol: Path | None,
    columns: Mapping[str, str],
    changes: Changes,
    like: Mapping[str, Any] | None = None,
) -> LogShown:
    """Read a logger's table, find what nobody stated, and draw it.

    Raises Unusable, with all that is wrong or unclear in one sentence.
    """
    like = like or {}
    changes = changes_like(like, changes)
    columns = {**like.get("columns", {}), **columns}
    station: Station | None = like.get("station")
    unit: Unit | None = like.get("unit")
    gravity, source = _gravity(changes, station, home)
    notes = [*source]
    place = (station or Station(id="unknown")).model_copy(update={"gravity_m_s2": gravity})
    understood = read_log(path, protocol, columns, changes, station=place, unit=unit)
    understood = _across_breaks(understood)
    if protocol is None:
        understood = _with_segments(understood)
        notes.append("no protocol: rests and turns were found; rates are proposals")
    recording = understood.recording
    labels = recording.manifest.segments or ()
    right = codes_put_right(with_instants(recording))
    doubts = (*right.put_right, *on_sight(right, labels))
    notes += _missing_positions(recording)
    if changes.commanded_rate is None and any(label.kind == "rate" for label in labels):
        notes.append(NO_COMMANDED_RATE)
    notes += label_doubts(recording, doubts)
    return LogShown(
        understood, protocol is None, doubts, (*understood.notes, *notes),
        draw_recording(recording, home.path / "understood" / f"{path.stem}.svg"),
    )  # fmt: skip


@stage("import")
def keep_log(shown: LogShown, home: Home, *, confirmed: bool) -> Imported:
    """Add what was understood to the store.

    confirmed: a person has seen the rates that were proposed; else turns that nobody stated are
    left out, for the gyro is not its own reference.
    """
    recording = shown.understood.recording
    if shown.proposed and not confirmed:
        rests = tuple(s for s in shown.segments if s.kind == "static")
        manifest = recording.manifest.model_copy(update={"segments": rests or None})
        recording = replace(recording, manifest=manifest)
    run, is_new = runs.add(recording, home)
    return Imported(run, is_new)


def _gravity(
    changes: Changes, station: Station | None, home: Home
) -> tuple[float | None, tuple[str, ...]]:
    """Local gravity, m/s², and where it comes from; None where nobody states it."""
    if changes.gravity:
        return changes.gravity, (f"g is {changes.gravity:g} m/s², as given",)
    if station is not None and station.gravity_m_s2:
        known = station.gravity_m_s2
        return known, (f"g is {known:g} m/s², as in the run it is like",)
    laboratory = settings.laboratory(home)
    if laboratory is not None and laboratory.latitude_deg is not None:
        gravity = round(normal_gravity(laboratory.latitude_deg), 5)
        return gravity, (f"g is {gravity:g} m/s², normal gravity at the laboratory's latitude",)
    return None, ()


def _across_breaks(understood: Understood) -> Understood:
    """With the rows after breaks of the clock in their places, which the manifest says."""
    breaks = [
        Break(one.row, int(understood.lines[one.row]), one.step, one.began, ran_on=True)
        for one in understood.breaks
    ]
    recording, seen = across_breaks(understood.recording, breaks, understood.lines)
    if not seen:
        return replace(understood, recording=recording)
    imported = dict((recording.manifest.model_extra or {})["imported"])
    seen_as_json = TypeAdapter(list[Seen]).dump_python(list(seen), mode="json")
    imported[SEEN] = [*imported.get(SEEN, ()), *seen_as_json]
    manifest = recording.manifest.model_copy(update={"imported": imported})
    return replace(understood, recording=replace(recording, manifest=manifest))


def _with_segments(understood: Understood) -> Understood:
    """Rests and turns found, where no protocol states them."""
    recording = understood.recording
    rests = find_segments(recording)
    found = sorted((*rests, *steady_turns(recording, rests)), key=lambda s: s.t_start)
    manifest = recording.manifest.model_copy(update={"segments": tuple(found) or None})
    return replace(understood, recording=replace(recording, manifest=manifest))


def _missing_positions(recording: Recording) -> list[str]:
    """A sentence where some axes were never put up or down."""
    held = {s.up for s in recording.manifest.segments or () if s.kind == "static" and s.up}
    missing = [up for up in UPS if up not in held]
    if not held or not missing:
        return []
    return [
        f"{len(missing)} of the six positions are missing (no rest has {', '.join(missing)} up): "
        "scale factor and bias of an accelerometer need its axis both up and down"
    ]


def shown_of(recording: Recording, segment: Segment) -> str:
    """What the readings show of a segment: the force along the axis up, or the rate about it."""
    rows = recording.imu.rows(segment.t_start, segment.t_end)
    if rows.stop <= rows.start:
        return "no rows"
    if segment.kind == "static":
        accel = recording.imu.stack(ACCEL, rows).mean(axis=0)
        if not np.isfinite(accel).all():
            return "-"
        axis = int(np.abs(accel).argmax())
        return f"accel_{AXES[axis]} {accel[axis]:+.3f} m/s²"
    gyro = recording.imu.stack(GYRO, rows).mean(axis=0)
    axis = int(np.abs(gyro).argmax()) if segment.axis is None else AXES.index(segment.axis)
    return f"gyro_{AXES[axis]} {np.degrees(gyro[axis]):+.3f} deg/s"


def draw_recording(recording: Recording, path: Path) -> Path:
    """Writes a picture of rates and forces over time with the segments behind them."""
    imu, labels = recording.imu, recording.manifest.segments or ()
    panels = ((GYRO, "deg/s", float(np.degrees(1.0))), (ACCEL, "m/s²", 1.0))

    def content(figure: "Figure") -> None:
        every = figure.subplots(len(panels), 1, sharex=True)
        for axes, (triad, unit, factor) in zip(every, panels, strict=True):
            for label in labels:
                if label.kind in SHADES:
                    axes.axvspan(label.t_start, label.t_end, color=SHADES[label.kind], lw=0)
            for name, colour in zip(triad, COLOURS, strict=True):
                if name in imu.columns and np.isfinite(imu.columns[name]).any():
                    band = envelope(imu.t, factor * imu.columns[name], BINS)
                    axes.plot(band.t, band.low, color=colour, lw=0.8, label=name)
                    axes.plot(band.t, band.high, color=colour, lw=0.8)
            axes.set_ylabel(unit)
            axes.tick_params(colors=GREY)
            if axes.lines:
                axes.legend(loc="upper right", ncols=3)
        every[-1].set_xlim(imu.t[0], imu.t[-1])
        time_axis(every[-1], MAIN)

    with writing_in_home(path):
        path.write_text(
            draw(recording.manifest.recording_id, WIDTH, HEIGHT, content), encoding="utf-8"
        )
    return path
