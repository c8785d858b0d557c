"""`make factory`: a whole line on this machine for two days, judged."""

import sys
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from tests.proof.factory.guard import guarded
from tests.proof.factory.run import LONGEST_S, Settings, run


def main(
    units: Annotated[int, typer.Option(metavar="N", min=4, help="Units that are ordered.")] = 100,
    seed: Annotated[int, typer.Option(min=0, help="Draws units, faults and kills.")] = 1,
    speed: Annotated[
        float, typer.Option(min=1.0, help="Station seconds in a second, at most.")
    ] = 100.0,
    minutes: Annotated[
        float, typer.Option(min=1.0, help="Production is broken off after so long.")
    ] = 2 * LONGEST_S / 60,
    busy: Annotated[
        bool, typer.Option("--busy", help="Other programs want every core meanwhile.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The table is written here, as Markdown.")
    ] = None,
) -> None:
    """Two days of production with everything that it needs; exits with 1 if a promise broke."""
    settings = Settings(units, seed, speed, out, minutes * 60, busy)
    sys.exit(guarded(partial(run, settings)))


if __name__ == "__main__":
    typer.run(main)
