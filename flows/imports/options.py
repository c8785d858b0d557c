"""Options of `mimucal import`."""

from pathlib import Path
from typing import Annotated, Literal

import typer

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
