"""The table of what was promised and what came, as Markdown."""

from collections.abc import Sequence

from tests.proof.factory.judge import Row
from tests.proof.factory.part import Part
from tests.proof.factory.play import Played

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


def table(rows: Sequence[Row]) -> str:
    """A row for each promise."""
    lines = [f"| {' | '.join(COLUMNS)} |", f"|{'---|' * len(COLUMNS)}"]
    for row in rows:
        verdict = "holds" if row.holds else "**FAILS**"
        cells = (row.promise, row.expected, row.got, verdict)
        lines.append(f"| {' | '.join(_cell(cell) for cell in cells)} |")
    return "\n".join(lines)


def page(
    about: str, rows: Sequence[Row], played: Played | None, parts: Sequence[Part]
) -> str:  # fmt: skip
    """about: the text before the table. parts: as they ended, with what they used."""
    text = [about, table(rows), ""]
    if played is not None:
        text += ["| killed | after orders | answers again after (s) |", "|---|---|---|"]
        text += [f"| {each.part} | {each.after} | {each.away_s:.1f} |" for each in played.happened]
        if played.events:
            text += ["", "What the operators had to do:", ""]
            text += [f"- {_cell(event)}" for event in played.events]
    used = sorted(parts, key=lambda part: -part.processor_s)
    text += ["", "| part, with what it started | processor (s) |", "|---|---|"]
    text += [f"| {part.name} | {part.processor_s:.0f} |" for part in used]
    return "\n".join((*text, ""))


def _cell(text: str) -> str:
    return " ".join(text.replace("|", "\\|").split())
