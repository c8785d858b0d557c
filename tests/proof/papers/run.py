"""`make prove ARGS="--papers DIR"`: certificates of every kind as PDF and as images of pages."""

from pathlib import Path

import pypdfium2  # type: ignore[import-untyped]

from schemas.text import BOTH, CONTRACTED
from tasks.certificate.documents import faces_of
from tests.proof.papers.cases import FOLDERS, cases

DOTS_PER_POINT = 2.0


def run_papers(folder: Path | None, *_: object) -> None:
    """Writes each kind by either specification, in the three settings of the languages."""
    assert folder is not None
    for method in FOLDERS:
        for name, certificate in cases(method):
            for language in (*CONTRACTED, BOTH):
                assert certificate.order is not None
                order = certificate.order.model_copy(update={"language": language})
                pdf = faces_of(certificate.model_copy(update={"order": order}), None).pdf
                _write(folder / f"{method}-{name}-{language}", pdf)
    print(folder)


def _write(folder: Path, pdf: bytes) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "certificate.pdf").write_bytes(pdf)
    for number, page in enumerate(pypdfium2.PdfDocument(pdf), start=1):
        image = page.render(scale=DOTS_PER_POINT).to_pil()
        image.save(folder / f"page-{number:02d}.png")
