"""The arguments and options of the command line, with what they may be."""

import math
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any

import typer

MAX_DAYS = 36_500
LAST_PORT = 65_534  # the unit is on the next


def _option(metavar: str, text: str, *names: str, **more: Any) -> Any:
    return typer.Option(*names, metavar=metavar, help=text, **more)


def _positive(value: float | None) -> float | None:
    if value is not None and not (math.isfinite(value) and value > 0):
        raise typer.BadParameter(f"{value} is not a number above 0.")
    return value


def _whole_days(value: datetime | None) -> datetime | None:
    """A day that has come: nothing was calibrated tomorrow."""
    if value is not None and value.date() > datetime.now().date():
        raise typer.BadParameter(f"{value:%Y-%m-%d} is still to come.")
    return value


Json = Annotated[bool, typer.Option("--json", help="One JSON document on standard output.")]
Run = Annotated[str, typer.Argument(metavar="RUN", help="Run id, or path to a recording.")]

Reviewed = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[PATH…]", help="Recordings, or folders of them; default: the store's runs."
    ),
]
ReviewFolder = Annotated[
    Path | None, _option("DIR", "Folder for review.json; nothing is written without it.", "--out")
]

Log = Annotated[
    bool, typer.Option("--log", help="Every change of its state, when and why, and nothing else.")
]

METHOD = "jjf2003, joint or jjf1536; default: the recording's standard."
UNCERTAINTY = (
    "gum: law of propagation; montecarlo: distributions drawn (JCGM 101); example: as Appendix A "
    "of the specification does it."
)
TERMS = (
    "Physics that `explain` found, taken off the readings first; the result stands beside the one "
    "without it."
)
Method = Annotated[str | None, _option("NAME", METHOD)]
Uncertainty = Annotated[str, _option("NAME", UNCERTAINTY)]
Terms = Annotated[str | None, _option("NAME,NAME", TERMS)]

CALIBRATED_ON = "Day of calibration, for a recording that does not say when it was made."
AS_FOUND = "Run of the unit before it was adjusted (an id or a path); RUN is then as left."
AsFound = Annotated[str | None, _option("RUN", AS_FOUND, "--as-found")]
Budget = Annotated[
    bool, typer.Option("--budget", help="Print the uncertainty budgets on the certificate.")
]
InvalidRun = Annotated[
    bool,
    typer.Option("--invalid-run", help="Report an invalid run too, without any verdict."),
]
BY = "Who does it; default: MIMUCAL_USER."
DRAFTED_BY = "Who drafts it; default: MIMUCAL_USER, else the laboratory's operator."
USER = "MIMUCAL_USER"
Certificate = Annotated[
    str, typer.Argument(metavar="CERTIFICATE", help="Its number, or the key of a draft.")
]
By = Annotated[str | None, _option("NAME", BY, envvar=USER, show_envvar=False)]
Operator = Annotated[
    str | None, _option("NAME", DRAFTED_BY, "--by", envvar=USER, show_envvar=False)
]
Reason = Annotated[str | None, _option("TEXT", "What stands beside the step in the trail.")]
Why = Annotated[str, _option("TEXT", "Why; it stands in the trail, and on an amendment.")]
AmendedRun = Annotated[
    str | None, _option("RUN", "Another run on which it stands; default: that of before.", "--run")
]
TrailForm = Annotated[str, _option("FORM", "table, csv or jsonl.", "--as")]
Tolerance = Annotated[str | None, _option("FILE", "Limits of the product model (TOML or JSON).")]
Laboratory = Annotated[str | None, _option("FILE", "The laboratory (TOML or JSON).")]
Order = Annotated[str | None, _option("FILE", "The client's order (TOML or JSON).")]
CalibratedOn = Annotated[
    datetime | None,
    _option("YYYY-MM-DD", CALIBRATED_ON, formats=["%Y-%m-%d"], callback=_whole_days),
]

RESULT = "Result id or mimu-calibration/1 file; default: the model is fitted to the run."
OWN_RESULT = "Result id or mimu-calibration/1 file; default: the run's own."
ReportFolder = Annotated[
    Path | None, _option("DIR", "Folder for the report; nothing is written without it.")
]
NewFolder = Annotated[Path, _option("DIR", "New folder for the simulated recording.", "--out")]
Result = Annotated[str | None, _option("RESULT", RESULT)]
OwnResult = Annotated[str | None, _option("RESULT", OWN_RESULT, "--calibration")]
Simulated = Annotated[
    Path | None, _option("PATH", "The same run as another simulator has it: a recording.")
]

CALIBRATED = "Result id, id of a calibrated run, or mimu-calibration/1 file."
CORRECTION = "json, yaml, c (a header), ros (parameters), kalibr (imu.yaml) or csv."
Calibrated = Annotated[str, typer.Argument(metavar="RESULT", help=CALIBRATED)]
As = Annotated[str, _option("FORM", CORRECTION, "--as")]
ToCorrect = Annotated[
    str, typer.Argument(metavar="RECORDING", help="Run id, or path to a recording.")
]
CorrectedFolder = Annotated[
    Path, _option("DIR", "New folder for the corrected recording.", "--out")
]

CalendarOf = Annotated[
    str | None, _option("CLIENT", "Print the due dates of a client as an iCalendar instead.")
]
NothingSent = Annotated[bool, typer.Option("--dry-run", help="List only; nothing is sent.")]
OfUnit = Annotated[str, typer.Argument(metavar="SERIAL", help="Serial number of the unit.")]
EquipmentFile = Annotated[
    Path, typer.Argument(metavar="FILE", help="Measurement standards (mimu-equipment/1).")
]

Paths = Annotated[
    list[Path],
    typer.Argument(metavar="PATH...", help="mimu-recording/1 folders, MCAP files, ROS 2 bags."),
]
Manifest = Annotated[Path | None, _option("FILE", "manifest.json for an MCAP file that has none.")]
Salvage = Annotated[
    bool, typer.Option("--salvage", help="Take what is whole of a cut-off MCAP file.")
]
Verified = Annotated[
    Path | None,
    typer.Argument(
        metavar="[PATH]",
        help="A recording, checked as import would, or a certificate's PDF, DCC or record; "
        "default: all.",
    ),
]
Trust = Annotated[
    Path | None,
    _option("FILE", "Certificates (PEM) under one of which a certificate's signer must stand."),
]
Within = Annotated[int, _option("DAYS", "Days ahead.", min=0, max=MAX_DAYS)]
Units = Annotated[int, _option("NUMBER", "Simulated units; a record needs 2000.", min=1)]
Out = Annotated[Path | None, _option("FILE", "Where the record (.json) and its page (.html) go.")]

WHAT = "runs, results, segments or certificates."
TABLE_FILE = (
    "Where it goes; default: standard output. With --as parquet, a folder is one file for each "
    "station and month (station=…/month=…)."
)
What = Annotated[str, typer.Argument(metavar="WHAT", help=WHAT)]
TableForm = Annotated[str, _option("FORM", "csv or parquet.", "--as")]
TableFile = Annotated[Path | None, _option("PATH", TABLE_FILE, "--out")]
EQUIPMENT = "Measurement standard (name, serial number or certificate), or station."
OF_PROCEDURE = "Name of a procedure, or a standard."
CODE_VERSION = "Beginning of the version that made the newest result."
SCHEDULER = "Scheduler of the dask cluster (with --engine dask)."
WORKERS = "Processes; default: one for each processor."
CHANGES = "Folder for report.json, changed.csv and changed.svg."
Since = Annotated[
    datetime | None, _option("YYYY-MM-DD", "First day of recording.", formats=["%Y-%m-%d"])
]
Until = Annotated[
    datetime | None, _option("YYYY-MM-DD", "Last day of recording.", formats=["%Y-%m-%d"])
]
Model = Annotated[str | None, _option("NAME", "Model of the unit.")]
Serial = Annotated[str | None, _option("NUMBER", "Serial number of the unit.")]
StationId = Annotated[str | None, _option("ID", "Station on which it was recorded.", "--station")]
OfEquipment = Annotated[str | None, _option("NAME", EQUIPMENT, "--equipment")]
Equipment = Annotated[str, typer.Argument(metavar="EQUIPMENT", help=EQUIPMENT)]
OfProcedure = Annotated[str | None, _option("NAME", OF_PROCEDURE, "--procedure")]
CodeVersion = Annotated[str | None, _option("VERSION", CODE_VERSION)]
Engine = Annotated[str, _option("NAME", "local (processes) or dask (a cluster).")]
Scheduler = Annotated[str | None, _option("ADDRESS", SCHEDULER)]
Workers = Annotated[int | None, _option("NUMBER", WORKERS, min=1)]
ChangesFolder = Annotated[str | None, _option("DIR", CHANGES, "--out")]
Before = Annotated[
    datetime,
    _option("YYYY-MM-DD", "Taken into the store before this day (UTC).", formats=["%Y-%m-%d"]),
]
Delete = Annotated[
    bool, typer.Option("--delete", help="Delete it; without this it is only listed.")
]
DeletedBy = Annotated[
    str | None,
    _option("NAME", "Who deletes; default: MIMUCAL_USER.", "--by", envvar="MIMUCAL_USER",
            show_envvar=False),
]  # fmt: skip
WouldBeDone = Annotated[
    bool, typer.Option("--dry-run", help="Say what would be done; nothing is read or made.")
]

SPEED = "Station seconds in a wall second"
DEMO_SPEED = f"{SPEED}; default: what the procedure lets it keep up with."
PORT = "Modbus/TCP port; the unit is on the next. 0: any two that are free."
Station = Annotated[str, typer.Argument(metavar="STATION", help="Station file (TOML or JSON).")]
Move = Annotated[
    bool, typer.Option("--move", help="Also turn each axis of the table by 1 degree and back.")
]
Procedure = Annotated[str, _option("NAME|FILE", "Name of a procedure, or a file.")]
DryRun = Annotated[
    bool,
    typer.Option("--dry-run", help="Hold the procedure against every limit; nothing moves."),
]
Resume = Annotated[
    bool,
    typer.Option(
        "--resume", help="Go on with the run of this unit and procedure that was interrupted."
    ),
]
Speed = Annotated[float, _option("FACTOR", f"{SPEED}.", callback=_positive)]
DemoSpeed = Annotated[float | None, _option("FACTOR", DEMO_SPEED, callback=_positive)]
Ahrs = Annotated[
    bool,
    typer.Option("--ahrs", help="One axis and an AHRS, for JJF 1536; else three and a MIMU."),
]
Seed = Annotated[int, _option("NUMBER", "Which virtual unit.", min=0)]
Host = Annotated[str, _option("ADDRESS", "Address on which it listens.")]
Port = Annotated[int, _option("NUMBER", PORT, min=0, max=LAST_PORT)]
PagesPort = Annotated[int, _option("NUMBER", "TCP port; 0: any that is free.", min=0, max=65_535)]
UserName = Annotated[str, typer.Argument(metavar="NAME", help="As the trail has it.")]
ROLE = "viewer, operator, verifier, issuer or administrator."
UserRole = Annotated[str, _option("ROLE", ROLE, "--role")]
Faults = Annotated[
    list[str] | None, _option("NAME[@SECONDS]", "A fault of the station; may be repeated.")
]
StationFile = Annotated[Path, _option("FILE", "Where the file for `mimucal acquire` is written.")]
Truth = Annotated[Path | None, _option("FILE", "Where the unit's truth is written.")]

Runs = Annotated[
    list[str],
    typer.Argument(metavar="RUN...", help="Run ids, or paths to recordings, of one unit."),
]
Effects = Annotated[
    str | None,
    _option("EFFECT,EFFECT", "Catalogue names to be told apart; one alone is told from none."
            " Default: what explain leaves open.", "--for"),
]  # fmt: skip
Minutes = Annotated[
    float, typer.Option(metavar="MIN", help="The longest that it may take.", callback=_positive)
]
BaseProcedure = Annotated[
    Path | None,
    _option("FILE", "A procedure whose room, warm-up and settling are kept.", "--procedure"),
]
NewProcedure = Annotated[Path | None, _option("FILE", "New procedure file.", "--out")]
AbleStation = Annotated[
    Path | None,
    _option("FILE", "Station file; default: what the run's own table did.", "--station"),
]
