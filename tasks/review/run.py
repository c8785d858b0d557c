"""Whose run it is: what its manifest tells of unit, lot, station, model and site."""

from typing import Any

from schemas.recording import Manifest, Station
from schemas.review import Level
from tasks.review.pool import ReviewedRun


def reviewed_run(run: str, manifest: Manifest) -> ReviewedRun:
    """A run by its manifest; `run`: what it is called."""
    unit, free = manifest.unit, manifest.model_extra or {}
    carriers: dict[Level, str] = {
        "unit": f"{unit.model} {unit.serial}",
        "station": manifest.station.id,
        "model": unit.model,
    }
    told: dict[Level, Any] = {
        "lot": (unit.model_extra or {}).get("lot"),
        "site": _site(manifest.station),
    }
    carriers |= {level: str(name) for level, name in told.items() if name is not None}
    return ReviewedRun(run, str(free.get("acquired_at") or manifest.recording_id), carriers)


def _site(station: Station) -> Any:
    """The site that a station names, else its latitude and gravity, which stations there share."""
    named = (station.model_extra or {}).get("site")
    if named is not None or station.latitude_deg is None:
        return named
    gravity = "" if station.gravity_m_s2 is None else f", {station.gravity_m_s2:.4f} m/s²"
    return f"{station.latitude_deg:.2f}°{gravity}"
