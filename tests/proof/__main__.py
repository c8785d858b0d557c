"""`python -m tests.proof`: the sealed trial from the command line (`make prove`)."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from schemas.base import Unusable
from tests.proof.prove import run_prove, run_station

UNUSABLE = 2


def main(
    seed: Annotated[int, typer.Option(min=0, help="Which trial.")] = 1,
    short: Annotated[
        bool, typer.Option("--short", help="Some thirty recordings in place of four hundred.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="New folder for the trial; default: proof-SEED here."),
    ] = None,
    real: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Besides: real recordings in DIR, by hand and with known changes hidden in them.",
        ),
    ] = None,
    station: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=1,
            max=160,
            help="Nothing but N short recordings of the virtual station.",
        ),
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="evidence.json on standard output.")
    ] = False,
) -> None:
    """Show in a sealed trial what `explain` finds, and what it does not.

    Recordings of an independent plant, explained blind, scored against the truth.
    """
    try:
        if station is not None:
            run_station(station, out)
        else:
            run_prove(seed, short, out, as_json, real)
    except Unusable as refused:
        print(refused, file=sys.stderr)
        raise typer.Exit(UNUSABLE) from None


if __name__ == "__main__":
    typer.run(main)
