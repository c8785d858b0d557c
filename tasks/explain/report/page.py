"""Writes the report folder: a page, its charts, the result and the prediction as data."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from schemas.base import Unusable
from schemas.discrepancy import Discrepancy
from tasks.explain.explanation import CHANNELS, Explanation
from tasks.explain.report import statements
from tasks.explain.report.discrepancy import before_after_svg, cells_of
from tasks.explain.report.verdict import detected, shares_svg, small_remainders, tested
from tasks.explain.report.where import where_svg
from tasks.rendering import inline_each, page
from tasks.rendering.chart import FINDINGS, GREY, picture_file
from tasks.version import code_version
from tasks.words import LANGUAGES, message, say
from tasks.words.numbers import USUAL_K, chi2, percent, quantities

TEMPLATE = Path(__file__).parent / "templates" / "report.html"
BADGES = {"no_mismatch": "good", "explained": "good", "partly_explained": "part",
          "unexplained": "bad"}  # fmt: skip


def write_report(
    discrepancy: Discrepancy, explanation: Explanation, folder: Path
) -> tuple[Path, ...]:
    """Writes report.html, report.json, its pictures and prediction.parquet.

    Each file appears whole or not at all; the page comes last. Returns their paths. Raises
    Unusable where the folder cannot be written.
    """
    pictures = pictures_of(discrepancy, explanation)
    contents = {
        "prediction.parquet": _prediction(explanation),
        **{
            picture_file(name, language): picture.encode()
            for name, by_language in pictures.items()
            for language, picture in by_language.items()
        },
        "report.json": (discrepancy.model_dump_json(indent=1) + "\n").encode(),
        "report.html": report_html(discrepancy, explanation, pictures).encode(),
    }
    return tuple(_appear(folder, name, content) for name, content in contents.items())[::-1]


def pictures_of(discrepancy: Discrepancy, explanation: Explanation) -> dict[str, dict[str, str]]:
    """The pictures of a report, SVG by name and language."""
    cells = cells_of(explanation)
    drawn: dict[str, Callable[[str], str]] = {
        "where": partial(where_svg, discrepancy, cells),
        "before_after": partial(before_after_svg, explanation, cells),
        "shares": partial(shares_svg, discrepancy),
    }
    return {name: {language: of(language) for language in LANGUAGES} for name, of in drawn.items()}


def report_html(
    discrepancy: Discrepancy,
    explanation: Explanation,
    pictures: Mapping[str, Mapping[str, str]],
) -> str:
    """The HTML of a report: one file, every language, with its pictures in it."""
    return page(
        TEMPLATE,
        title=say(message("report-title", recording=discrepancy.recording_id), LANGUAGES[0]),
        discrepancy=discrepancy,
        badge=BADGES[discrepancy.verdict],
        **{name: inline_each(picture) for name, picture in pictures.items()},
        small=small_remainders(discrepancy),
        colours=dict(enumerate(FINDINGS)),
        other_colour=GREY,
        names=statements,
        statements=statements,
        coverage=USUAL_K,
        quantities=quantities,
        percent=percent,
        chi2=chi2,
        tested=tested(explanation.recording),
        detected=detected(discrepancy.detection),
        recording=explanation.recording,
        code_version=code_version(),
    )


def _appear(folder: Path, name: str, content: bytes) -> Path:
    """Writes a file under another name first, then gives it its own; makes the folder.

    Raises Unusable where the disk refuses.
    """
    path, draft = folder / name, folder / f".{name}.part"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        draft.write_bytes(content)
        draft.replace(path)
    except OSError as error:
        raise Unusable(
            f"{path} cannot be written ({error.strerror or error}); name another folder with "
            "--out, or free some space and grant access."
        ) from error
    finally:
        if draft.is_file():
            draft.unlink()
    return path


def _prediction(explanation: Explanation) -> bytes:
    """prediction.parquet: t (s), and each channel's nominal and found reading, rad/s and m/s².

    One row for each row of the unit's stream; NaN where the motion is not known.
    """
    columns = {"t": explanation.recording.imu.t}
    for i, channel in enumerate(CHANNELS):
        columns[f"{channel}_nominal"] = explanation.nominal[:, i]
        columns[f"{channel}_found"] = explanation.found[:, i]
    arrays = {name: np.ascontiguousarray(each, float) for name, each in columns.items()}
    sink = pa.BufferOutputStream()
    pq.write_table(pa.table(arrays), sink, compression="zstd")
    return bytes(sink.getvalue().to_pybytes())
