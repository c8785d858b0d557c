"""A validation record as a page to read: one self-contained file with a picture and a table."""

from pathlib import Path
from typing import TYPE_CHECKING

from schemas.validation import EVIDENCE, TARGET_SHARE, Coverage, ValidationRecord
from tasks.rendering import draw, inline, page

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TEMPLATE = Path(__file__).parent / "templates" / "validation.html"
LOWEST = 0.88  # share that the picture shows
GOOD, BAD, ASKED_FOR = "#14691b", "#a1190d", "#dcefdc"


def validation_html(record: ValidationRecord) -> str:
    """The HTML of a record."""
    rows = [
        (method, name, item)
        for method, of_method in record.methods.items()
        for name, item in of_method.items.items()
    ]
    covered = [(f"{method}: {name}", item.coverage) for method, name, item in rows if item.coverage]
    return page(
        TEMPLATE,
        record=record,
        rows=rows,
        valid=sum(item.valid for _, _, item in rows),
        outside=sum(len(coverage.outside) for _, coverage in covered),
        asked=[f"{100 * share:.0f}" for share in TARGET_SHARE],
        evidence=EVIDENCE,
        picture=inline(_picture(covered)) if covered else "",
    )


def _picture(rows: list[tuple[str, Coverage]]) -> str:
    """Shares inside the 95 % interval with their own intervals, against what is asked."""

    def content(figure: "Figure") -> None:
        axes = figure.subplots()
        axes.axvspan(*TARGET_SHARE, color=ASKED_FOR)
        for place, (_, coverage) in enumerate(rows):
            inside = TARGET_SHARE[0] <= coverage.inside_95 <= TARGET_SHARE[1]
            colour = GOOD if inside else BAD
            low, high = (max(end, LOWEST) for end in coverage.confidence)
            axes.hlines(place, low, high, color=colour, linewidth=2)
            axes.plot(max(coverage.inside_95, LOWEST), place, "o", color=colour, markersize=7)
        axes.set(xlim=(LOWEST, 1.0), ylim=(len(rows) - 0.4, -0.6))
        axes.set_yticks(range(len(rows)), [name for name, _ in rows])
        axes.xaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")
        axes.tick_params(axis="y", length=0)

    return draw("Shares inside the 95 % interval", 900, 22 * len(rows) + 40, content)
