"""The site in the manifest, checked against the laboratory's own file."""

from collections.abc import Iterator

from schemas.recording import Recording
from schemas.text import Remark
from tasks.run_validity.remark import run_remark

LATITUDE_DEG = 0.1  # two figures of one place, each rounded


def laboratory_remarks(recording: Recording, latitude_deg: float | None) -> Iterator[Remark]:
    """A latitude other than the laboratory's; nothing if it does not state its own.

    The gyros of many units do not show Earth's rotation, and then nothing in the data reveals it.
    """
    stated = recording.manifest.station.latitude_deg
    if stated is None or latitude_deg is None:
        return
    if abs(stated - latitude_deg) > LATITUDE_DEG:
        yield run_remark(
            "laboratory_latitude", run="invalid", latitude=f"{stated:g}", own=f"{latitude_deg:g}"
        )
