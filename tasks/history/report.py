"""The report of a re-processing: JSON for scripts, a table for people, a picture of both."""

import csv
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from schemas.history import Change, Reprocessing
from tasks.rendering.chart import AFTER, BEFORE, GREY, PALE, draw
from tasks.specifications.items import item_title
from tasks.words import say

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, FRAME, ROW = 900, 110, 30  # px
LEAST, MOST = 1e-6, 100.0  # U: what is beyond stands at the edge
SPREAD = 0.6  # of a row, over which the runs of an item lie


def write_report(report: Reprocessing, folder: Path) -> list[Path]:
    """Writes report.json, changed.csv and changed.svg into a folder that is there."""
    texts = {
        "report.json": report.model_dump_json(indent=1) + "\n",
        "changed.csv": _table(report.changed),
        "changed.svg": changed_svg(report),
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    return [folder / name for name in texts]


def _table(changed: tuple[Change, ...]) -> str:
    text = StringIO()
    rows = csv.DictWriter(text, list(Change.model_fields), lineterminator="\n")
    rows.writeheader()
    rows.writerows(change.model_dump() for change in changed)
    return text.getvalue()


def changed_svg(report: Reprocessing) -> str:
    """The picture: a row for each item, a mark for each element of each run that moved."""
    items = list(dict.fromkeys(change.item for change in report.changed))
    title = f"What moved in {report.done} results, of which {report.unchanged} are as they were"

    def content(figure: "Figure") -> None:
        axes: Any = figure.add_subplot()
        axes.set_title(title)
        axes.set(xscale="log", xlim=(LEAST, MOST), ylim=(max(len(items), 1), 0))
        axes.set_xlabel("change of the value / U", loc="right")
        axes.set_yticks([row + 0.5 for row in range(len(items))], [_title(item) for item in items])
        axes.axvline(1.0, color=BEFORE, linewidth=1.0)
        for row, item in enumerate(items):
            axes.axhline(row + 0.5, color=PALE, linewidth=1.0, zorder=0)
            moved = [c.in_U for c in report.changed if c.item == item]
            x = [min(max(step or LEAST, LEAST), MOST) for step in moved]
            y = [row + 0.5 + SPREAD * ((k + 0.5) / len(x) - 0.5) for k in range(len(x))]
            beyond = [BEFORE if step > 1.0 else AFTER for step in x]
            axes.scatter(x, y, s=9.0, c=beyond, linewidths=0.0)
        if not items:
            axes.text(0.5, 0.5, "nothing moved", transform=axes.transAxes, ha="center", color=GREY)

    return draw(title, WIDTH, FRAME + ROW * max(len(items), 2), content)


def _title(item: str) -> str:
    return say(item_title(item), "en")
