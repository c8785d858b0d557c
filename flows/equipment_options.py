"""Arguments and options of the commands of the register of standards."""

from datetime import datetime
from pathlib import Path
from typing import Annotated, Literal

import typer

from flows.options import _day as day
from flows.options import _option as option
from flows.options import _whole_days as not_in_future
from schemas.text import CONTRACTED

StandardDcc = Annotated[
    Path, typer.Argument(metavar="FILE", help="XML of the standard's calibration certificate.")
]
Deviation = Annotated[
    Literal["corrected", "budgeted"],
    typer.Argument(help="Whether its errors are corrected, or counted with U."),
]
Entry = Annotated[Path, option("FILE", "New file for the entry (.json).", "--out")]
OfStandard = Annotated[str, typer.Argument(metavar="SERIAL", help="Serial number of the standard.")]
Checked = Annotated[str, option("TEXT", "What was checked.", "--what")]
CheckedInChinese = Annotated[
    str, option("TEXT", "The same in Chinese.", f"--what-{CONTRACTED[-1]}")
]
CheckResult = Annotated[float, option("NUMBER", "What it found.", "--result")]
CheckLimit = Annotated[float, option("NUMBER", "Largest size of a result that passes.", "--limit")]
CheckedOn = Annotated[
    datetime | None,
    option("YYYY-MM-DD", "Day of the check; default: today.", "--on", parser=day,
            callback=not_in_future),
]  # fmt: skip
CheckUnit = Annotated[str, option("UNIT", "Unit of both; default: none.", "--unit")]
