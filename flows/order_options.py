"""Arguments and options of production orders, and of the virtual station that they are tried on."""

from pathlib import Path
from typing import Annotated

import typer

from flows.options import _option as option

OrderedStation = Annotated[
    str, typer.Argument(metavar="STATION", help="Id of one of the home's stations.")
]
SERIALS = "Serial number of the unit; repeated, one for each place of the station."
Serials = Annotated[list[str], option("NUMBER", SERIALS, "--serial")]
OF_THE_STATION = "default: that of the station file's unit."
OrderedModel = Annotated[str | None, option("NAME", f"Model; {OF_THE_STATION}", "--model")]
OrderedManufacturer = Annotated[
    str | None, option("NAME", f"Manufacturer; {OF_THE_STATION}", "--manufacturer")
]
ClientOrder = Annotated[
    str | None, option("FILE", "The client's order (TOML or JSON).", "--client-order")
]
OrderNumber = Annotated[
    str | None, option("NUMBER", "By which the order is known; default: one is drawn.", "--number")
]
OrdersFile = Annotated[
    Path, typer.Argument(metavar="FILE", help="Orders, as CSV in UTF-8 with a line of names.")
]
ORDER_STATES = "waiting, running, done, failed or cancelled."
OrderState = Annotated[str | None, option("STATE", ORDER_STATES, "--state")]
GivenNumber = Annotated[str, typer.Argument(metavar="NUMBER", help="Number of the order.")]
VirtualId = Annotated[
    str | None,
    option("NAME", "Id of the station; default: VIRTUAL- and the port, or 1 for port 5020.",
            "--id"),
]  # fmt: skip
MountedSerial = Annotated[
    str | None, option("NUMBER", "Serial number of the unit; default: from the seed.", "--serial")
]
