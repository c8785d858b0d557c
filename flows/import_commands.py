"""The command `import` and its options."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from flows import options
from schemas.base import Unusable
from storage.home import home

if TYPE_CHECKING:
    from schemas.recording import Segment
    from storage.formats.convert import Changes
    from storage.home import Home
    from tasks.stages.import_recording import Imported
    from tasks.stages.logger_table import LogShown


# Options of `mimucal import`.

COLUMNS = (
    "Which column is which channel, NAME=COLUMN by its name or its number from 1; NAME: t, "
    "gyro_x, gyro_y, gyro_z, accel_x, accel_y, accel_z, temperature, angle_x, angle_y, angle_z. "
    "Needed only where names and units in the header leave a doubt."
)
UNITS = (
    "Units, where the header does not say them or is wrong: gyro (rad/s, deg/s, mdps, deg/h, rpm, "
    "counts as 131/dps), accel (m/s2, g, mg, ft/s2, counts as 16384/g), t (s, ms, us, ns, or a "
    "rate as 100Hz), temperature (degC, K), angle and table (rad, deg), labels (s, ms)."
)
AXES = (
    "Axes exchanged or inverted, NEW=OLD: x=-y,y=x for both triads, gyro_z=-gyro_z for one; or all "
    "three in their order, as -y,x,z."
)
Files = Annotated[
    list[Path],
    typer.Argument(
        metavar="PATH...",
        help="mimu-recording/1 folders, MCAP files, ROS 2 bags; or a logger's table (csv, tsv, "
        "xlsx, parquet).",
    ),
]
Protocol = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="What was done when, one line for each position or rate: columns start, end or "
        "duration, up (+x … -z), turn_deg, axis, rate_deg_s, angle_deg. Without it rests and turns "
        "are found, and shown.",
    ),
]
Columns = Annotated[str | None, typer.Option(metavar="NAME=COLUMN,…", help=COLUMNS)]
Units = Annotated[str | None, typer.Option(metavar="NAME=UNIT,…", help=UNITS)]
Axes = Annotated[str | None, typer.Option(metavar="MAP", help=AXES)]
Shift = Annotated[
    float,
    typer.Option(metavar="SECONDS", help="Added to all times of the protocol, or of the labels."),
]
Gravity = Annotated[
    float | None,
    typer.Option(
        metavar="G",
        min=9.7,
        max=9.9,
        help="Local gravity in m/s², which one g is taken for; default: that of the laboratory's "
        "latitude, else the standard 9.80665.",
    ),
]
CommandedRate = Annotated[
    float | None,
    typer.Option(
        metavar="SHARE",
        min=0.0,
        max=0.1,
        help="How well the table holds a commanded rate, as ± a share of it (2e-4), where no "
        "encoders were recorded; without it scale factors get no U.",
    ),
]
Like = Annotated[
    str | None,
    typer.Option(metavar="RUN", help="Take columns, units, axes, unit and station from that run."),
]
Yes = Annotated[bool, typer.Option("--yes", help="Keep what was understood without asking.")]
Stamps = Annotated[
    Literal["header", "log"],
    typer.Option(help="Of a bag: the stamps in the headers, or the times of recording."),
]


# The command that takes recordings into the store.

app = typer.Typer()


@app.command(name="import", epilog="Example: mimucal import log.csv --protocol protocol.csv --yes")
def import_(
    paths: Files,
    protocol: Protocol = None,
    columns: Columns = None,
    units: Units = None,
    axes: Axes = None,
    shift: Shift = 0.0,
    gravity: Gravity = None,
    commanded_rate: CommandedRate = None,
    like: Like = None,
    yes: Yes = False,
    stamps: Stamps = "header",
    manifest: options.Manifest = None,
    salvage: options.Salvage = False,
    as_json: options.Json = False,
) -> None:
    """Import recordings into the store, or a logger's table.

    Of a table it shows what it understood, and keeps it once that is confirmed. Identical content
    imported twice is one run.
    """
    from flows.terminal import print_json, working
    from storage.formats import convert
    from storage.formats.logger.columns import CHANNELS
    from storage.formats.logger.read import is_log
    from tasks.stages.import_recording import import_recording

    named = convert.pairs("--columns", columns, CHANNELS)
    changes = convert.Changes(
        units=convert.pairs("--units", units, convert.UNIT_NAMES),
        axes=convert.axis_map(axes) if axes else None,
        shift=shift,
        gravity=gravity,
        commanded_rate=commanded_rate or None,
    )
    entries: list[dict[str, Any]] = []
    try:
        for path in paths:
            if is_log(path):
                entries += _import_log(
                    path, home(), protocol, named, changes, like, yes=yes, as_json=as_json
                )
                continue
            _refuse_for_recording(path, protocol, columns)
            with working(f"importing {path.name}"):
                done = import_recording(
                    path, home(), manifest=manifest, salvage=salvage,
                    changes=_like(changes, like, home()) or None, by_log_time=stamps == "log",
                )  # fmt: skip
            if done.left_out:
                left_out = ", ".join(done.left_out)
                print(f"{path}: left out, no stream takes them: {left_out}", file=sys.stderr)
            for doubt in done.doubts:
                print(f"{path}: {doubt}", file=sys.stderr)
            entries.append(_entry(done))
            _print_kept(done, as_json)
    finally:  # what was imported before one that is refused is listed, too
        if as_json and (entries or not sys.exc_info()[0]):
            print_json({"format": "mimu-import/1", "runs": entries})


def _refuse_for_recording(path: Path, protocol: Path | None, columns: str | None) -> None:
    for option, given in (("--protocol", protocol), ("--columns", columns)):
        if given is not None:
            raise Unusable(f"{option} is for a logger's table, and {path} is none; leave it out.")


def _like(changes: "Changes", like: str | None, home: "Home") -> "Changes":
    """The changes of a recording, like those of an earlier run."""
    if like is None:
        return changes
    from tasks.stages.logger_table import changes_like, mapping_like

    return changes_like(mapping_like(like, home), changes)


def _import_log(
    path: Path, home: "Home", protocol: Path | None, columns: dict[str, str], changes: "Changes",
    like: str | None, *, yes: bool, as_json: bool,
) -> list[dict[str, Any]]:  # fmt: skip
    """Shows what was understood of a logger's table, and keeps it; nothing where it is not kept."""
    from flows.terminal import working
    from tasks.stages.logger_table import keep_log, mapping_like, understand

    with working(f"reading {path.name}"):
        shown = understand(
            path, home, protocol=protocol, columns=columns, changes=changes,
            like=None if like is None else mapping_like(like, home),
        )  # fmt: skip
    if not as_json:
        _print_understood(shown)
    confirmed = not yes and not as_json and _confirmed(shown)
    document = {"understood": _understood_document(shown)}
    if not (yes or confirmed):
        print(f"{path}: nothing was kept; add --yes to keep it as shown", file=sys.stderr)
        return [document]
    done = keep_log(shown, home, confirmed=confirmed)
    left_out = [s for s in shown.segments if s.kind != "static"] if shown.proposed else []
    if left_out and not confirmed:
        print(
            f"{path}: {len(left_out)} turns were left out, for nobody stated their rates; write "
            "them in a protocol",
            file=sys.stderr,
        )
    _print_kept(done, as_json)
    return [_entry(done) | document]


def _confirmed(shown: "LogShown") -> bool:
    """Whether the person at the terminal says yes; no where there is none."""
    if not sys.stdin.isatty():
        return False
    asked = "Keep it, with these rates" if shown.proposed else "Keep it"
    return typer.confirm(asked)


def _entry(done: "Imported") -> dict[str, Any]:
    return {
        "run": done.run.id,
        "recording_id": done.run.recording_id,
        "new": done.is_new,
        "left_out": list(done.left_out),
        "doubts": list(done.doubts),
    }


def _print_kept(done: "Imported", as_json: bool) -> None:
    if not as_json:
        print(done.run.id if done.is_new else f"{done.run.id} (already there)")


def _print_understood(shown: "LogShown") -> None:
    """Columns and units, segments with what the readings show, notes, doubts, and the picture."""
    from flows.terminal import print_rows
    from tasks.stages.logger_table import shown_of
    from tasks.words import say

    recording = shown.understood.recording
    imu = recording.imu
    print_rows(
        "Columns",
        ("channel", "column", "unit", "known by"),
        [(row.channel, row.column, row.unit, row.how) for row in shown.understood.rows],
    )
    seconds = float(imu.t[-1] - imu.t[0])
    rate = (len(imu) - 1) / seconds if seconds else 0.0
    print(f"{len(imu)} rows over {seconds:.3f} s, {rate:.6g} Hz")
    if shown.segments:
        title = "Segments found (rates proposed)" if shown.proposed else "Segments"
        print_rows(
            title,
            ("segment", "from, s", "to, s", "what", "the readings show"),
            [
                (
                    s.name,
                    f"{s.t_start:.2f}",
                    f"{s.t_end:.2f}",
                    _moved(s),
                    shown_of(recording, s),
                )
                for s in shown.segments
            ],
        )
    else:
        print("no segments: nothing can be estimated; give a protocol")
    for note in shown.notes:
        print(f"· {note}")
    for doubt in shown.doubts:
        print(f"! {say(doubt)}")
    print(f"picture: {shown.picture}")


def _understood_document(shown: "LogShown") -> dict[str, Any]:
    """The same as a part of the command's JSON."""
    from tasks.words import say

    recording = shown.understood.recording
    return {
        "rows": len(recording.imu),
        "seconds": float(recording.imu.t[-1] - recording.imu.t[0]),
        "gravity_m_s2": shown.understood.gravity,
        "columns": {
            row.channel: {"column": row.column, "unit": row.unit, "known_by": row.how}
            for row in shown.understood.rows
        },
        "segments": [s.model_dump(mode="json", exclude_none=True) for s in shown.segments],
        "segments_found": shown.proposed,
        "notes": list(shown.notes),
        "doubts": [say(doubt) for doubt in shown.doubts],
        "picture": str(shown.picture),
    }


def _moved(segment: "Segment") -> str:
    if segment.kind == "static":
        turned = "" if segment.turn_deg is None else f", turned {segment.turn_deg:g}°"
        return f"rest, {segment.up or 'aslant'} up{turned}"
    if segment.kind == "rate":
        return f"{segment.rate_deg_s:+g} deg/s about {segment.axis}"
    return f"{segment.angle_deg:+g}° about {segment.axis}"
