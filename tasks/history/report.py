"""The report of a re-processing: JSON for scripts, a table for people, a picture of both."""

import csv
from io import StringIO
from pathlib import Path

from schemas.history import Change, Reprocessing
from tasks.history.picture import changed_svg


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
