"""Arguments and options shared by the commands, and the values they accept."""

import math
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from schemas.base import Unusable
from schemas.text import CONTRACTED

MAX_DAYS = 36_500
LAST_PORT = 65_534  # the unit uses the next port


def _option(metavar: str, text: str, *names: str, **more: Any) -> Any:
    return typer.Option(*names, metavar=metavar, help=text, **more)


def _positive(value: float | None) -> float | None:
    if value is not None and not (math.isfinite(value) and value > 0):
        raise typer.BadParameter(f"{value} must be a number greater than 0.")
    return value


def _day(text: str | datetime) -> datetime:
    try:
        return text if isinstance(text, datetime) else datetime.strptime(text, "%Y-%m-%d")
    except ValueError as error:
        raise typer.BadParameter(f"{text!r} is not a date; write it as 2026-03-31.") from error


def _whole_days(value: datetime | None) -> datetime | None:
    """A day that is not in the future."""
    if value is not None and value.date() > datetime.now().date():
        raise typer.BadParameter(f"{value:%Y-%m-%d} is in the future.")
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
    bool, typer.Option("--log", help="Only the log: every change of state with time and cause.")
]

METHOD = "jjf2003, joint or jjf1536; default: the recording's standard."
UNCERTAINTY = (
    "gum: law of propagation; montecarlo: propagation of distributions (JCGM 101); example: as in "
    "Appendix A of the specification."
)
TERMS = (
    "Effects found by `explain` that the readings are corrected for first; the result is kept "
    "beside the uncorrected one."
)
Method = Annotated[str | None, _option("NAME", METHOD)]
Uncertainty = Annotated[str, _option("NAME", UNCERTAINTY)]
Terms = Annotated[str | None, _option("NAME,NAME", TERMS)]

CALIBRATED_ON = "Day of calibration, for a recording that does not state it."
AS_FOUND = "Run of the unit before adjustment (id or path); RUN is then the run as left."
AsFound = Annotated[str | None, _option("RUN", AS_FOUND, "--as-found")]
Budget = Annotated[
    bool, typer.Option("--budget", help="Print the uncertainty budgets on the certificate.")
]
InvalidRun = Annotated[
    bool,
    typer.Option("--invalid-run", help="Report even an invalid run, without any verdict."),
]
BY = "Person who does it; default: MIMUCAL_USER."
DRAFTED_BY = "Person who drafts it; default: MIMUCAL_USER, else the laboratory's operator."
USER = "MIMUCAL_USER"
Certificate = Annotated[
    str, typer.Argument(metavar="CERTIFICATE", help="Certificate number, or the key of a draft.")
]
By = Annotated[str | None, _option("NAME", BY, envvar=USER, show_envvar=False)]
Operator = Annotated[
    str | None, _option("NAME", DRAFTED_BY, "--by", envvar=USER, show_envvar=False)
]
Reason = Annotated[str | None, _option("TEXT", "Remark on this step in the audit trail.")]
Why = Annotated[
    str, _option("TEXT", "Reason, recorded in the audit trail and printed on an amendment.")
]
AmendedRun = Annotated[
    str | None,
    _option("RUN", "Run the new certificate is based on; default: the previous one.", "--run"),
]
TrailForm = Annotated[str, _option("FORM", "table, csv or jsonl.", "--as")]
Tolerance = Annotated[str | None, _option("FILE", "Limits of the product model (TOML or JSON).")]
Laboratory = Annotated[str | None, _option("FILE", "The laboratory (TOML or JSON).")]
Order = Annotated[str | None, _option("FILE", "The client's order (TOML or JSON).")]
CalibratedOn = Annotated[
    datetime | None,
    _option("YYYY-MM-DD", CALIBRATED_ON, parser=_day, callback=_whole_days),
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
    Path | None, _option("PATH", "Recording of the same run made by another simulator.")
]

CALIBRATED = "Result id, id of a calibrated run, or mimu-calibration/1 file."
Calibrated = Annotated[str, typer.Argument(metavar="RESULT", help=CALIBRATED)]

CalendarOf = Annotated[
    str | None, _option("CLIENT", "Print a client's due dates in iCalendar format instead.")
]
NothingSent = Annotated[bool, typer.Option("--dry-run", help="List only; nothing is sent.")]
OfUnit = Annotated[str, typer.Argument(metavar="SERIAL", help="Serial number of the unit.")]
EquipmentFile = Annotated[
    Path, typer.Argument(metavar="FILE", help="Measurement standards (mimu-equipment/1).")
]

Manifest = Annotated[Path | None, _option("FILE", "manifest.json for an MCAP file that has none.")]
Salvage = Annotated[
    bool, typer.Option("--salvage", help="Recover the intact part of a truncated MCAP file.")
]
Verified = Annotated[
    Path | None,
    typer.Argument(
        metavar="[PATH]",
        help="A recording, checked as on import, or a certificate's PDF, DCC or record; "
        "default: the whole store.",
    ),
]
Trust = Annotated[
    Path | None,
    _option("FILE", "Trusted certificates (PEM), one of which must have issued the signer's."),
]
Within = Annotated[int, _option("DAYS", "Days ahead.", min=0, max=MAX_DAYS)]
Units = Annotated[
    int, _option("NUMBER", "Number of simulated units; a record requires 2000.", min=1)
]
Out = Annotated[
    Path | None,
    _option("FILE", "Output file for the record (.json); its page (.html) is written beside it."),
]

WHAT = "runs, results, segments or certificates."
TABLE_FILE = (
    "Output file; default: standard output. With --as parquet, a folder receives one file per "
    "station and month (station=…/month=…)."
)
What = Annotated[str, typer.Argument(metavar="WHAT", help=WHAT)]
TableForm = Annotated[str, _option("FORM", "csv or parquet.", "--as")]
TableFile = Annotated[Path | None, _option("PATH", TABLE_FILE, "--out")]
EQUIPMENT = "Measurement standard (name, serial number or certificate), or station."
OF_PROCEDURE = "Name of a procedure, or a standard."
CODE_VERSION = "Version, or its beginning, that produced the latest result."
SCHEDULER = "Scheduler of the dask cluster (with --engine dask)."
WORKERS = "Number of processes; default: one per processor."
CHANGES = "Folder for report.json, changed.csv and changed.svg (changed-LANGUAGE.svg: the others)."
Since = Annotated[datetime | None, _option("YYYY-MM-DD", "First day of recording.", parser=_day)]
Until = Annotated[datetime | None, _option("YYYY-MM-DD", "Last day of recording.", parser=_day)]
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
    _option("YYYY-MM-DD", "Imported before this day (UTC).", parser=_day),
]
Delete = Annotated[
    bool,
    typer.Option("--delete", help="Actually delete; without this, candidates are only listed."),
]
DeletedBy = Annotated[
    str | None,
    _option("NAME", "Person who deletes; default: MIMUCAL_USER.", "--by", envvar="MIMUCAL_USER",
            show_envvar=False),
]  # fmt: skip
WouldBeDone = Annotated[bool, typer.Option("--dry-run", help="Only print what would be done.")]

BackupFolder = Annotated[
    Path, typer.Argument(metavar="DIR", help="Folder of the backups, outside the home.")
]
BackupName = Annotated[
    str | None, _option("NAME", "Name of the backup; default: the newest.", "--backup")
]
Confirm = Annotated[bool, typer.Option("--confirm", help="Give up the way back.")]
Back = Annotated[bool, typer.Option("--back", help="Put back the catalogue of before.")]
AlertText = Annotated[str, typer.Argument(metavar="TEXT", help="The sentence.")]

SPEED = "Simulated seconds per second of real time"
DEMO_SPEED = f"{SPEED}; default: as fast as the procedure allows."
PORT = "Modbus/TCP port; the unit uses the next one. 0: any two free ports."
Station = Annotated[str, typer.Argument(metavar="STATION", help="Station file (TOML or JSON).")]
StationOrFile = Annotated[
    str, typer.Argument(metavar="ID|FILE", help="Station id, or its station file.")
]
StoppedBy = Annotated[
    str | None,
    _option("NAME", "Person who stops it; default: MIMUCAL_USER, else the login.", "--by"),
]
ReleasedBy = Annotated[
    str | None,
    _option(
        "NAME", "Person who saw that it may turn; default: MIMUCAL_USER, else the login.", "--by"
    ),
]
Move = Annotated[
    bool, typer.Option("--move", help="Also turn each table axis by 1 degree and back.")
]
Procedure = Annotated[str, _option("NAME|FILE", "Name of a procedure, or a file.")]
DryRun = Annotated[
    bool,
    typer.Option(
        "--dry-run", help="Check the procedure against every limit without moving anything."
    ),
]
Resume = Annotated[
    bool,
    typer.Option("--resume", help="Continue the interrupted run of this unit and procedure."),
]
Speed = Annotated[float, _option("FACTOR", f"{SPEED}.", callback=_positive)]
DemoSpeed = Annotated[float | None, _option("FACTOR", DEMO_SPEED, callback=_positive)]
Ahrs = Annotated[
    bool,
    typer.Option(
        "--ahrs",
        help="A one-axis table with an AHRS, for JJF 1536, instead of three axes with a MIMU.",
    ),
]
Seed = Annotated[int, _option("NUMBER", "Random seed, which selects the virtual unit.", min=0)]
Host = Annotated[str, _option("ADDRESS", "Address to listen on.")]
Port = Annotated[int, _option("NUMBER", PORT, min=0, max=LAST_PORT)]
PagesPort = Annotated[int, _option("NUMBER", "TCP port; 0: any free port.", min=0, max=65_535)]
UserName = Annotated[
    str, typer.Argument(metavar="NAME", help="Name as recorded in the audit trail.")
]
ROLE = "viewer, operator, verifier, issuer or administrator."
UserRole = Annotated[str, _option("ROLE", ROLE, "--role")]
Faults = Annotated[
    list[str] | None, _option("NAME[@SECONDS]", "Fault to simulate; may be repeated.")
]
StationFile = Annotated[Path, _option("FILE", "Output: station file for `mimucal acquire`.")]
Added = Annotated[str, typer.Argument(metavar="ID", help="Id of a station of the home.")]
Schedule = Annotated[
    str | None,
    _option("CRON", "When it produces by itself, as '0 8 * * 1-5'; without it, when ordered."),
]
Timezone = Annotated[
    str | None,
    _option("ZONE", "Time zone of the schedules; default: that of this computer."),
]
Truth = Annotated[Path | None, _option("FILE", "Output: true parameters of the unit.")]

Runs = Annotated[
    list[str],
    typer.Argument(metavar="RUN...", help="Run ids, or paths to recordings, of one unit."),
]
Effects = Annotated[
    str | None,
    _option("EFFECT,EFFECT", "Effects to be distinguished; one alone is tested against its absence."
            " Default: what `explain` leaves open.", "--for"),
]  # fmt: skip
Minutes = Annotated[
    float, typer.Option(metavar="MIN", help="Maximum duration.", callback=_positive)
]
BaseProcedure = Annotated[
    str | None,
    _option(
        "NAME|FILE",
        "Procedure whose environment limits, warm-up and settling times are adopted.",
        "--procedure",
    ),
]
NewProcedure = Annotated[Path | None, _option("FILE", "Output: procedure file.", "--out")]
AbleStation = Annotated[
    Path | None,
    _option("FILE", "Station file; default: the motions made by the run's own table.", "--station"),
]


def fields(chosen: Mapping[str, Any]) -> dict[str, Any]:
    """What was chosen on the command line as the fields of an order, where anything was.

    chosen: the parameters of the command, by their names.
    """
    return {
        "client_order" if name == "order" else name: str(value)
        if isinstance(value, Path)
        else value
        for name, value in chosen.items()
        if value is not None and name != "as_json"
    }


def person(by: str | None) -> str:
    """Who does what is entered in the audit trail; Unusable where nobody is named."""
    if not by or not by.strip():
        raise Unusable("Say who does it: give --by NAME, or let MIMUCAL_USER name the person.")
    return by.strip()


# Arguments and options of production orders, and of the virtual station that they are tried on.

OrderedStation = Annotated[
    str, typer.Argument(metavar="STATION", help="Id of one of the home's stations.")
]
SERIALS = "Serial number of the unit; repeated, one for each place of the station."
Serials = Annotated[list[str], _option("NUMBER", SERIALS, "--serial")]
OF_THE_STATION = "default: that of the station file's unit."
OrderedModel = Annotated[str | None, _option("NAME", f"Model; {OF_THE_STATION}", "--model")]
OrderedManufacturer = Annotated[
    str | None, _option("NAME", f"Manufacturer; {OF_THE_STATION}", "--manufacturer")
]
ClientOrder = Annotated[
    str | None, _option("FILE", "The client's order (TOML or JSON).", "--client-order")
]
OrderNumber = Annotated[
    str | None, _option("NUMBER", "By which the order is known; default: one is drawn.", "--number")
]
OrdersFile = Annotated[
    Path, typer.Argument(metavar="FILE", help="Orders, as CSV in UTF-8 with a line of names.")
]
ORDER_STATES = "waiting, running, done, failed or cancelled."
OrderState = Annotated[str | None, _option("STATE", ORDER_STATES, "--state")]
GivenNumber = Annotated[str, typer.Argument(metavar="NUMBER", help="Number of the order.")]
VirtualId = Annotated[
    str | None,
    _option("NAME", "Id of the station; default: VIRTUAL-PORT, or VIRTUAL-1 on port 5020.", "--id"),
]
MountedSerial = Annotated[
    str | None, _option("NUMBER", "Serial number of the unit; default: from the seed.", "--serial")
]


# Options of `certify`, `amend` and `acquire`: who measured, and whether it is a report.

OPERATED_BY = "Person who carries it out; default: MIMUCAL_USER, else asked for at a terminal."
OperatedBy = Annotated[
    str | None,
    typer.Option("--by", metavar="NAME", help=OPERATED_BY, envvar=USER, show_envvar=False),
]
CARRIED_OUT_BY = "Person who carried out the measurement, for a recording that does not say it."
CarriedOutBy = Annotated[
    str | None, typer.Option("--operator", metavar="NAME", help=CARRIED_OUT_BY)
]
AGREEMENT = (
    "Agreement with the client by which this is a report of less than a certificate states "
    "(ISO/IEC 17025, 7.8.1.3); printed on it."
)
Report = Annotated[str | None, typer.Option("--report", metavar="AGREEMENT", help=AGREEMENT)]


# Arguments and options of `export` and `apply`.

CORRECTION = (
    "json, yaml, c (a header), ros (parameters), kalibr (imu.yaml) or csv; evidence: what "
    "every value and U of the result is made of."
)
As = Annotated[str, _option("FORM", CORRECTION, "--as")]
ToCorrect = Annotated[
    str, typer.Argument(metavar="RECORDING", help="Run id, or path to a recording.")
]
CorrectedFolder = Annotated[
    Path, _option("DIR", "New folder for the corrected recording.", "--out")
]
WithU = Annotated[
    bool,
    typer.Option(
        "--with-u", help="Add columns u_gyro_x … with the standard uncertainty of each reading."
    ),
]


# Arguments and options of the commands of the register of standards.

StandardDcc = Annotated[
    Path, typer.Argument(metavar="FILE", help="XML of the standard's calibration certificate.")
]
Deviation = Annotated[
    Literal["corrected", "budgeted"],
    typer.Argument(help="Whether its errors are corrected, or counted with U."),
]
Entry = Annotated[Path, _option("FILE", "New file for the entry (.json).", "--out")]
OfStandard = Annotated[str, typer.Argument(metavar="SERIAL", help="Serial number of the standard.")]
Checked = Annotated[str, _option("TEXT", "What was checked.", "--what")]
CheckedInChinese = Annotated[
    str, _option("TEXT", "The same in Chinese.", f"--what-{CONTRACTED[-1]}")
]
CheckResult = Annotated[float, _option("NUMBER", "What it found.", "--result")]
CheckLimit = Annotated[float, _option("NUMBER", "Largest size of a result that passes.", "--limit")]
CheckedOn = Annotated[
    datetime | None,
    _option(
        "YYYY-MM-DD", "Day of the check; default: today.", "--on", parser=_day, callback=_whole_days
    ),
]
CheckUnit = Annotated[str, _option("UNIT", "Unit of both; default: none.", "--unit")]
