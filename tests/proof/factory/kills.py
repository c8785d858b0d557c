"""A line whose worker, engine, server, database and station are killed again and again.

`python -m tests.proof line-kills --each 20`: the factory's production and its judge, with these
kills in the place of its own: no order is stuck for a minute once all is up again, and none
is measured twice.
"""

import sys
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from tests.proof.factory.disturbances import OF_A_RUN
from tests.proof.factory.guard import guarded
from tests.proof.factory.run import Settings, run
from tests.proof.factory.works import STATIONS

SPEED = 100.0
ABOUT = """# A line whose parts are killed again and again

`python -m tests.proof.kills.line --units {{units}} --each {each} --seed {{seed}}`, {{machine}}:
[the factory](../../../deploy/factory.md), {{units}} units in {{minutes:.1f}} min, with SIGKILL
{each} times each for the database, Prefect's server, the process of a run, a station and its
worker, one kill at a time and at a random moment, the next once its part answers again.
"""


def main(
    each: Annotated[int, typer.Option(min=1, help="Kills of each part.")] = 20,
    units: Annotated[int, typer.Option(min=4, help="Units that are ordered.")] = 100,
    seed: Annotated[int, typer.Option(min=0, help="Draws units, faults and kills.")] = 1,
    minutes: Annotated[float, typer.Option(help="Production is broken off after so long.")] = 120.0,
    out: Annotated[Path | None, typer.Option(help="The table is written here.")] = None,
) -> None:
    """Kill each part so often; exits with 1 if a promise broke.

    A kill takes as long as an order: with fewer units the last runs end before their kills.
    """
    station = STATIONS[0]
    parts = ("PostgreSQL", "Prefect server", OF_A_RUN, f"worker station-{station}", station)
    longest_s = minutes * 60
    settings = Settings(
        units,
        seed,
        SPEED,
        out,
        longest_s,
        is_busy=False,
        parts=parts * each,
        within_s=longest_s,
        about=ABOUT.format(each=each),
    )
    sys.exit(guarded(partial(run, settings)))


if __name__ == "__main__":
    typer.run(main)
