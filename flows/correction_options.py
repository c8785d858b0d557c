"""Arguments and options of `export` and `apply`."""

from pathlib import Path
from typing import Annotated

import typer

from flows.options import _option as option

CORRECTION = (
    "json, yaml, c (a header), ros (parameters), kalibr (imu.yaml) or csv; evidence: what "
    "every value and U of the result is made of."
)
As = Annotated[str, option("FORM", CORRECTION, "--as")]
ToCorrect = Annotated[
    str, typer.Argument(metavar="RECORDING", help="Run id, or path to a recording.")
]
CorrectedFolder = Annotated[Path, option("DIR", "New folder for the corrected recording.", "--out")]
WithU = Annotated[
    bool,
    typer.Option(
        "--with-u", help="Add columns u_gyro_x … with the standard uncertainty of each reading."
    ),
]
