"""The report as a folder: a page to read, its pictures, the answer and the prediction as data."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from schemas.discrepancy import Consequence, Discrepancy
from tasks.explain.correction.consequences import moved_by
from tasks.explain.explanation import Explanation
from tasks.explain.report import names, statements
from tasks.explain.report.before_after import before_after_svg
from tasks.explain.report.cells import cells_of
from tasks.explain.report.files import appear, prediction
from tasks.explain.report.verdict import detected, tested
from tasks.explain.report.where import where_svg
from tasks.pages import inline, page
from tasks.pages.chart import FINDINGS, GREY
from tasks.version import code_version
from tasks.words import LANGUAGES, message, say
from tasks.words.quantities import chi2, multiple, percent, quantities
from tasks.words.rounding import USUAL_K

TEMPLATE = Path(__file__).parent / "templates" / "report.html"
BADGES = {"no_mismatch": "good", "explained": "good", "partly_explained": "part",
          "unexplained": "bad"}  # fmt: skip


def write_report(
    discrepancy: Discrepancy, explanation: Explanation, folder: Path
) -> tuple[Path, ...]:
    """Writes report.html, report.json, where.svg, before_after.svg and prediction.parquet.

    Each file appears whole or not at all; the page comes last. Returns their paths. Raises
    Unusable where the folder cannot be written.
    """
    cells = cells_of(explanation)
    where, before_after = where_svg(discrepancy, cells), before_after_svg(explanation, cells)
    contents = {
        "prediction.parquet": prediction(explanation),
        "where.svg": where.encode(),
        "before_after.svg": before_after.encode(),
        "report.json": (discrepancy.model_dump_json(indent=1) + "\n").encode(),
        "report.html": report_html(discrepancy, explanation, where, before_after).encode(),
    }
    return tuple(appear(folder, name, content) for name, content in contents.items())[::-1]


def report_html(
    discrepancy: Discrepancy, explanation: Explanation, where: str, before_after: str
) -> str:
    """The HTML of a report: one file, every language, with its pictures in it."""
    return page(
        TEMPLATE,
        title=say(message("report-title", recording=discrepancy.recording_id), LANGUAGES[0]),
        discrepancy=discrepancy,
        badge=BADGES[discrepancy.verdict],
        where=inline(where),
        before_after=inline(before_after),
        colours=dict(enumerate(FINDINGS)),
        other_colour=GREY,
        names=names,
        statements=statements,
        coverage=USUAL_K,
        quantities=quantities,
        percent=percent,
        chi2=chi2,
        moved=list(_moved(discrepancy)),
        tested=tested(explanation),
        detected=detected(explanation),
        recording=explanation.recording,
        code_version=code_version(),
    )


def _moved(discrepancy: Discrepancy) -> Iterator[dict[str, Any]]:
    """The rows of the table of the certificate's values, and of verdicts without any."""
    for number, finding in enumerate(discrepancy.findings, 1):
        verdicts = {change.item: change for change in finding.verdict_changes}
        for moved in finding.consequences:
            yield _row(number, moved) | {"verdict": verdicts.get(moved.item)}
    for number, finding in enumerate(discrepancy.findings, 1):
        listed = {moved.item for moved in finding.consequences}
        for change in finding.verdict_changes:
            if change.item not in listed:
                nothing = Consequence(item=change.item, element="", before=None, after=None,
                                      U=None, unit="1")  # fmt: skip
                yield _row(number, nothing) | {"verdict": change}


def _row(number: int, moved: Consequence) -> dict[str, Any]:
    change = None
    if moved_by(moved):
        assert moved.before is not None
        assert moved.after is not None
        assert moved.U is not None
        change = multiple((moved.after - moved.before) / moved.U)
    return {
        "number": number,
        "title": names.element_title(moved.item, moved.element),
        "key": f"{moved.item}.{moved.element}" if moved.element else "",
        "made": quantities([moved.before, moved.after], moved.U, moved.unit),
        "change": change,
    }
