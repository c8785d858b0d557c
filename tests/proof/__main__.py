"""`python -m tests.proof NAME`: a study from the command line (`make prove ARGS="NAME …"`)."""

import sys
from importlib import import_module

import typer

from schemas.base import Unusable
from tests.surroundings import leave_production

UNUSABLE = 2
STUDIES = {  # by name: module, function
    "trial": ("trial.run", "trial"),
    "rough": ("trial.rough", "rough"),
    "stated": ("real.stated", "stated"),
    "real-values": ("real.values", "values"),
    "unlisted": ("unlisted", "unlisted"),
    "chance": ("chance", "chance"),
    "names": ("names", "names"),
    "station": ("station", "station"),
    "fleets": ("fleets", "fleets"),
    "next": ("next", "next_"),
    "coverage": ("coverage.run", "coverage"),
    "fuzz": ("fuzz", "fuzz"),
    "issue": ("issue", "issue"),
    "line": ("line_pages", "line"),
    "factory": ("factory.run", "factory"),
    "line-kills": ("factory.run", "line_kills"),
}


def app(asked: str) -> typer.Typer:
    """The command with the study that is asked for, or with all of them where none is."""
    made = typer.Typer(
        no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False,
        help="Studies on an independent plant, virtual stations and real recordings.",
    )  # fmt: skip
    made.callback()(lambda: None)  # so that a single study is asked for by its name, too
    for name, (module, function) in STUDIES.items():
        if name == asked or asked not in STUDIES:
            made.command(name)(getattr(import_module(f"tests.proof.{module}"), function))
    return made


if __name__ == "__main__":
    leave_production()
    try:
        app(sys.argv[1] if sys.argv[1:] else "")()
    except Unusable as refused:
        print(refused, file=sys.stderr)
        sys.exit(UNUSABLE)
