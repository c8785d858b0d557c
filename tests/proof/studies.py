"""The studies of the proof by their names."""

from typing import Annotated

import typer

from tests.proof.chance import chance
from tests.proof.factory.__main__ import main as factory
from tests.proof.factory.kills import main as line_kills
from tests.proof.faults import faults, resumes
from tests.proof.fleets import fleets
from tests.proof.fuzz import fuzz
from tests.proof.history import history
from tests.proof.hostile import hostile
from tests.proof.issue import issue
from tests.proof.kills import kills
from tests.proof.line_pages import line
from tests.proof.load import load
from tests.proof.names import names
from tests.proof.next import next_, next_station
from tests.proof.pages import pages, screens
from tests.proof.papers import papers
from tests.proof.real.run import real
from tests.proof.real.stated import stated
from tests.proof.real.values import values
from tests.proof.station import station
from tests.proof.stops import stops
from tests.proof.throughput import throughput
from tests.proof.trial.rough import rough
from tests.proof.trial.run import trial
from tests.proof.tune import peer_thresholds
from tests.proof.unlisted import unlisted

OF_EXPLAIN = (
    trial, rough, real, stated, values, unlisted, chance, names, station, fleets, next_,
    next_station, peer_thresholds,
)  # fmt: skip
OF_THE_LINE = (
    faults, fuzz, kills, resumes, stops, load, throughput, issue, pages, line, screens, papers,
    hostile, history,
)  # fmt: skip
NAMED = {next_: "next", values: "real-values"}

app = typer.Typer(
    no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False,
    help="Studies on an independent plant, virtual stations and real recordings.",
)  # fmt: skip
for panel, studies in (("Models and names", OF_EXPLAIN), ("Stations and lines", OF_THE_LINE)):
    for study in studies:
        name = NAMED.get(study, study.__name__.replace("_", "-"))
        app.command(name, rich_help_panel=panel)(study)
app.command("factory", rich_help_panel="Stations and lines")(factory)
app.command("line-kills", rich_help_panel="Stations and lines")(line_kills)


@app.command(rich_help_panel="Models and names")
def coverage(
    units: Annotated[int, typer.Argument(min=1, help="Units of each table.")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="Of the first unit.")] = 1,
) -> None:
    """How often stated intervals hold the truth on other tables."""
    from tests.proof.coverage.run import main

    main(units, seed)
