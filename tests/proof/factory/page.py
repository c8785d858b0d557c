"""The table of what was promised and what came, as Markdown."""

from collections.abc import Sequence

from tests.proof.factory.judge import Row
from tests.proof.factory.part import Part
from tests.proof.factory.play import Played
from tests.proof.study import table

COLUMNS = ("promise", "expected", "got", "verdict")
ABOUT = """# The factory

`make factory ARGS="--units {units} --seed {seed}"`, {machine}: PostgreSQL, a Prefect server behind
authentication, two stations with a worker each, a worker for the line, a dask scheduler with two
workers, an S3 server, the pages and a mail server, each killed (SIGKILL) once while {units} units
were produced in {minutes:.1f} min. {full} units were measured by `jjf2003` as it is shipped, the
others by the same clauses with dwells of {dwell:g} s in place of 30 s, on which no unit passes: a
run of the shipped procedure alone costs two cores a minute. The stations' clocks ran up to
{speed:g} times as fast, so that these are {hours:.0f} h of each station, and their tables kept ten
encoder samples a second.
"""


def table_of(rows: Sequence[Row]) -> str:
    """A row for each promise."""
    return "\n".join(table(COLUMNS, (
        (row.promise, row.expected, row.got, "holds" if row.holds else "**FAILS**") for row in rows
    )))  # fmt: skip


def page(
    about: str, rows: Sequence[Row], played: Played | None, parts: Sequence[Part]
) -> str:  # fmt: skip
    """about: the text before the table. parts: as they ended, with what they used."""
    text = [about, table_of(rows), ""]
    if played is not None:
        killed = ((each.part, each.after, f"{each.away_s:.1f}") for each in played.happened)
        text += table(("killed", "after orders", "answers again after (s)"), killed)
        if played.events:
            text += ["", "What the operators had to do:", ""]
            text += [f"- {' '.join(event.split())}" for event in played.events]
    used = sorted(parts, key=lambda part: -part.processor_s)
    text += ["", *table(("part, with what it started", "processor (s)"),
                        ((part.name, f"{part.processor_s:.0f}") for part in used))]  # fmt: skip
    return "\n".join((*text, ""))
