"""The table of what was promised and what came, as Markdown."""

from collections.abc import Sequence

from tests.proof.factory.judge import Row
from tests.proof.factory.play import Played

COLUMNS = ("promise", "expected", "got", "verdict")
ABOUT = """# The factory

`make factory ARGS="--units {units} --seed {seed}"`, {machine}: PostgreSQL, a Prefect server behind
authentication, two stations with a worker each, a worker for the line, a dask scheduler with two
workers, an S3 server, the pages and a mail server, each killed (SIGKILL) once while {units} units
were produced in {minutes:.1f} min. {full} units were measured by `jjf2003` as it is shipped, the
others by the same clauses and dwells with a warm-up of {warm_up:g} s in place of 600 s and faster
moves. Two days of a station's time passed at up to {speed:g} times the clock; its table kept ten
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


def page(about: str, rows: Sequence[Row], played: Played | None) -> str:
    """about: the text before the table."""
    parts = [about, table(rows), ""]
    if played is not None:
        kills = [f"| {each.part} | {each.after} | {each.away_s:.1f} |" for each in played.happened]
        parts += ["| killed | after orders | answers again after (s) |", "|---|---|---|", *kills]
        if played.events:
            parts += ["", "What the operators had to do:", ""]
            parts += [f"- {_cell(event)}" for event in played.events]
    return "\n".join((*parts, ""))


def _cell(text: str) -> str:
    return " ".join(text.replace("|", "\\|").split())
