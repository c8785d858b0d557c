"""`python -m tests.proof`: the sealed trial from the command line (`make prove`)."""

import sys
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from schemas.base import Unusable
from tests.proof.ablation.run import run_ablation
from tests.proof.chance.run import run_chance
from tests.proof.faults.run import run_faults
from tests.proof.fleets.run import run_fleets
from tests.proof.fuzz.run import run_fuzz
from tests.proof.history.run import run_history
from tests.proof.hostile.run import run_hostile
from tests.proof.issue.run import run_issue
from tests.proof.line.run import run_line
from tests.proof.next.on_station import run_next_on_station
from tests.proof.next.run import run_next
from tests.proof.pages.run import run_pages
from tests.proof.pages.screens import run_screens
from tests.proof.papers.run import run_papers
from tests.proof.prove import (
    run_kills,
    run_loaded,
    run_prove,
    run_resumes,
    run_station,
    run_stops,
)
from tests.proof.throughput.run import run_throughput
from tests.proof.trial.rough import run_rough
from tests.surroundings import leave_production

UNUSABLE = 2


def only(what: str, *names: str, most: int | None = None) -> Any:
    """An option that holds nothing but N of something."""
    return typer.Option(*names, metavar="N", min=1, max=most, help=f"Nothing but N {what}")


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
        int | None, only("short recordings of the virtual station.", most=160)
    ] = None,
    load: Annotated[int | None, only("demonstrations with every core busy.")] = None,
    kills: Annotated[int | None, only("acquisitions killed at random moments.")] = None,
    resumes: Annotated[int | None, only("acquisitions that are killed and go on.")] = None,
    stops: Annotated[int | None, only("stops at random moments, parts being down.")] = None,
    rough: Annotated[
        bool, typer.Option("--rough", help="Rough recordings in place of the catalogue's.")
    ] = False,
    engine: Annotated[
        Path | None,
        typer.Option(
            metavar="PATH",
            help="With --rough: the mimucal command of another checkout; again with the same "
            "--out, its answers stand beside the others.",
        ),
    ] = None,
    minutes: Annotated[
        float | None,
        typer.Option(
            min=0,
            help="With --rough, --ablation, --chance: begin no explanation after so many minutes.",
        ),
    ] = None,
    ablation: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Nothing but the names without each rule in turn, short trials and the station "
            "recorded in DIR, and of --real; goes on where it stopped.",
        ),
    ] = None,
    chance: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Nothing but wrong names in null recordings of --real, and in clean ones; answers "
            "stay in DIR, where it goes on.",
        ),
    ] = None,
    faults: Annotated[int | None, only("runs, each with a random fault.")] = None,
    fuzz: Annotated[int | None, only("damaged inputs for each parser.")] = None,
    throughput: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", min=1, help="Nothing but fast stations, each for so long."),
    ] = None,
    history: Annotated[int | None, only("recordings made again, here and by a cluster.")] = None,
    fleets: Annotated[int | None, only("fleets of many runs each.")] = None,
    next_: Annotated[int | None, only("open cases and what decides them.", "--next")] = None,
    next_on_station: Annotated[
        int | None,
        typer.Option(
            metavar="MINUTES", min=1, help="Nothing but what decides on the virtual station."
        ),
    ] = None,
    issue: Annotated[int | None, only("certificates issued at once, and kills.")] = None,
    pages: Annotated[int | None, only("random questions to each endpoint of the pages.")] = None,
    hostile: Annotated[
        int | None,
        typer.Option(
            metavar="N", min=1, help="Nothing but hostile calls of a line, N of them flow runs."
        ),
    ] = None,
    papers: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Nothing but certificates of every kind, to look at."),
    ] = None,
    line: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=1,
            help="Nothing but the store of a line with N runs, and what the pages say of it.",
        ),
    ] = None,
    screens: Annotated[
        int | None,
        typer.Option(
            metavar="N", min=1, help="Nothing but pictures of every page of a line with N runs."
        ),
    ] = None,
    write: Annotated[
        bool,
        typer.Option(
            "--write",
            help="With --chance, --faults, --fleets, --fuzz, --hostile, --issue, --line, --next, "
            "--pages, --throughput: into the evidence.",
        ),
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="evidence.json on standard output.")
    ] = False,
) -> None:
    """Show in a sealed trial what `explain` finds, and what it does not.

    Recordings of an independent plant, explained blind, scored against the truth.
    """
    only = (
        (run_station, station), (run_loaded, load), (run_kills, kills), (run_resumes, resumes),
        (run_stops, stops),
        (run_history, history), (run_next_on_station, next_on_station),
        (partial(run_papers, papers), 1 if papers else None),
        (partial(run_screens, seed), screens),
    )  # fmt: skip
    seeded = (
        (run_faults, faults), (run_fuzz, fuzz), (run_issue, issue), (run_fleets, fleets),
        (run_pages, pages), (run_next, next_), (run_hostile, hostile),
        (partial(run_line, out=out), line),
    )  # fmt: skip
    try:
        for run, count in only:
            if count is not None:
                run(count, out)
                return
        for run_seeded, count in seeded:
            if count is not None:
                run_seeded(count, seed, write)
                return
        if throughput is not None:
            run_throughput(throughput, write)
        elif ablation is not None:
            run_ablation(ablation, seed, real, minutes)
        elif chance is not None:
            run_chance(chance, seed, real, minutes, write)
        elif rough:
            run_rough(seed, short, out, engine, minutes)
        else:
            run_prove(seed, short, out, as_json, real)
    except Unusable as refused:
        print(refused, file=sys.stderr)
        raise typer.Exit(UNUSABLE) from None


if __name__ == "__main__":
    leave_production()
    typer.run(main)
