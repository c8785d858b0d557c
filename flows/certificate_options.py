"""Options of `certify`, `amend` and `acquire`: who measured, and whether it is a report."""

from typing import Annotated

import typer

from flows.options import USER

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
