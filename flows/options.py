"""The arguments and options of the command line, with what they may be."""

import math
from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

DAYS = 36_500
LAST_PORT = 65_534  # the unit is on the next


def _positive(value: float) -> float:
    if not (math.isfinite(value) and value > 0):
        raise typer.BadParameter(f"{value} is not a number above 0.")
    return value


def _positive_or_none(value: float | None) -> float | None:
    return value if value is None else _positive(value)


def _whole_days(value: datetime | None) -> datetime | None:
    """A day that has come: nothing was calibrated tomorrow."""
    if value is not None and value.date() > datetime.now().date():
        raise typer.BadParameter(f"{value:%Y-%m-%d} is still to come.")
    return value


Json = Annotated[bool, typer.Option("--json", help="One JSON document on standard output.")]
Run = Annotated[str, typer.Argument(metavar="RUN", help="Run id, or path to a recording.")]
Method = Annotated[
    str | None,
    typer.Option(
        metavar="NAME", help="jjf2003, joint or jjf1536; default: the recording's standard."
    ),
]
Uncertainty = Annotated[
    str,
    typer.Option(
        metavar="NAME",
        help="gum: law of propagation; montecarlo: distributions drawn (JCGM 101); example: as "
        "Appendix A of the specification does it.",
    ),
]
Terms = Annotated[
    str | None,
    typer.Option(
        metavar="NAME,NAME",
        help="Physics that `explain` found, taken off the readings first; the result stands "
        "beside the one without it.",
    ),
]
Budget = Annotated[
    bool, typer.Option("--budget", help="Print the uncertainty budgets on the certificate.")
]
Tolerance = Annotated[
    str | None, typer.Option(metavar="FILE", help="Limits of the product model (TOML or JSON).")
]
Laboratory = Annotated[
    str | None, typer.Option(metavar="FILE", help="The laboratory (TOML or JSON).")
]
Order = Annotated[
    str | None, typer.Option(metavar="FILE", help="The client's order (TOML or JSON).")
]
CalibratedOn = Annotated[
    datetime | None,
    typer.Option(
        metavar="YYYY-MM-DD",
        formats=["%Y-%m-%d"],
        callback=_whole_days,
        help="Day of calibration, for a recording that does not say when it was made.",
    ),
]
ReportFolder = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Folder for the report; nothing is written without it."),
]
Result = Annotated[
    str | None,
    typer.Option(
        metavar="RESULT",
        help="Result id or mimu-calibration/1 file; default: the model is fitted to the run.",
    ),
]
NewFolder = Annotated[
    Path, typer.Option("--out", metavar="DIR", help="New folder for the simulated recording.")
]
OwnResult = Annotated[
    str | None,
    typer.Option(
        "--calibration",
        metavar="RESULT",
        help="Result id or mimu-calibration/1 file; default: the run's own.",
    ),
]
Simulated = Annotated[
    Path | None,
    typer.Option(metavar="PATH", help="The same run as another simulator has it: a recording."),
]
Paths = Annotated[
    list[Path],
    typer.Argument(metavar="PATH...", help="mimu-recording/1 folders, MCAP files, ROS 2 bags."),
]
Manifest = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="manifest.json for an MCAP file that has none."),
]
Salvage = Annotated[
    bool, typer.Option("--salvage", help="Take what is whole of a cut-off MCAP file.")
]
Recording = Annotated[
    Path | None,
    typer.Argument(metavar="[PATH]", help="A recording, checked as import would; default: all."),
]
Station = Annotated[str, typer.Argument(metavar="STATION", help="Station file (TOML or JSON).")]
Procedure = Annotated[
    str, typer.Option(metavar="NAME|FILE", help="Name of a procedure, or a file.")
]
Within = Annotated[int, typer.Option(metavar="DAYS", min=0, max=DAYS, help="Days ahead.")]
Speed = Annotated[
    float,
    typer.Option(metavar="FACTOR", callback=_positive, help="Station seconds in a wall second."),
]
DemoSpeed = Annotated[
    float | None,
    typer.Option(
        metavar="FACTOR",
        callback=_positive_or_none,
        help="Station seconds in a wall second; default: what the procedure lets it keep up with.",
    ),
]
Ahrs = Annotated[
    bool,
    typer.Option("--ahrs", help="One axis and an AHRS, for JJF 1536; else three and a MIMU."),
]
Seed = Annotated[int, typer.Option(metavar="NUMBER", min=0, help="Which virtual unit.")]
Host = Annotated[str, typer.Option(metavar="ADDRESS", help="Address on which it listens.")]
Port = Annotated[
    int,
    typer.Option(
        metavar="NUMBER",
        min=0,
        max=LAST_PORT,
        help="Modbus/TCP port; the unit is on the next. 0: any two that are free.",
    ),
]
Faults = Annotated[
    list[str] | None,
    typer.Option(metavar="NAME[@SECONDS]", help="A fault of the station; may be repeated."),
]
StationFile = Annotated[
    Path,
    typer.Option(metavar="FILE", help="Where the file for `mimucal acquire` is written."),
]
Truth = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Where the unit's truth is written.")
]
Units = Annotated[
    int, typer.Option(metavar="NUMBER", min=1, help="Simulated units; a record needs 1000.")
]
Out = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Where the record (.json) and its page (.html) go."),
]
