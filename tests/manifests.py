"""Manifests of made-up recordings: what a test of them does not care about stands here once."""

from collections.abc import Mapping, Sequence
from typing import Any

from schemas.recording import FORMAT, Manifest

Axes = Mapping[str, Sequence[float]]
THREE_AXES: Axes = {"outer": (0, 0, 1), "middle": (1, 0, 0), "inner": (0, 0, 1)}


def manifest_of(
    name: str, station: Mapping[str, Any] | None = None, axes: Axes | None = None, **more: Any
) -> Manifest:
    """Of a recording, with fields of its station and the directions of its table's axes.

    more: further fields, or others than these.
    """
    table = {} if axes is None else {
        "table_axes": [{"name": axis, "direction": to} for axis, to in axes.items()]
    }  # fmt: skip
    return Manifest.model_validate({
        "format": FORMAT, "recording_id": name,
        "unit": {"manufacturer": "test", "model": "ideal", "serial": "1"},
        "station": {"id": "test", **(station or {}), **table}, **more,
    })  # fmt: skip
