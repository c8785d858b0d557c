"""Unit, lot, station, model and site of a run, from its manifest."""

from collections.abc import Mapping
from typing import Any

from schemas.recording import Manifest, Station
from schemas.review import Level
from tasks.review.pool import ReviewedRun


def reviewed_runs(manifests: Mapping[str, Manifest]) -> dict[str, ReviewedRun]:
    """Runs by their manifests, each with its carriers. A unit is identified by its serial
    number, and by its model too if several models share that number.
    """
    models: dict[str, set[str]] = {}
    for manifest in manifests.values():
        models.setdefault(manifest.unit.serial, set()).add(manifest.unit.model)
    shared = {serial for serial, of in models.items() if len(of) > 1}
    return {run: _reviewed(run, manifest, shared) for run, manifest in manifests.items()}


def _reviewed(run: str, manifest: Manifest, shared: set[str]) -> ReviewedRun:
    unit, free = manifest.unit, manifest.model_extra or {}
    serial = f"{unit.model} {unit.serial}" if unit.serial in shared else unit.serial
    carriers: dict[Level, str] = {
        "unit": serial, "station": manifest.station.id, "model": unit.model
    }  # fmt: skip
    named: dict[Level, Any] = {
        "lot": (unit.model_extra or {}).get("lot"),
        "site": _site(manifest.station),
    }
    carriers |= {level: str(name) for level, name in named.items() if name is not None}
    return ReviewedRun(run, str(free.get("acquired_at") or manifest.recording_id), carriers)


def _site(station: Station) -> Any:
    """The site that a station names, else its latitude and gravity, which stations there share."""
    named = (station.model_extra or {}).get("site")
    if named is not None or station.latitude_deg is None:
        return named
    gravity = "" if station.gravity_m_s2 is None else f", {station.gravity_m_s2:.4f} m/s²"
    return f"{station.latitude_deg:.2f}°{gravity}"
