"""Manifests of made-up recordings: what a test of them does not care about stands here once."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from schemas.recording import FORMAT, Manifest, Recording, Segment

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


def described(recording: Recording, **changes: Any) -> Recording:
    """The recording with other fields of its manifest."""
    return replace(recording, manifest=recording.manifest.model_copy(update=changes))


def at_station(recording: Recording, **changes: Any) -> Recording:
    """The recording with other facts of its station."""
    return described(recording, station=recording.manifest.station.model_copy(update=changes))


def relabelled(
    recording: Recording, change: Callable[[Segment], dict[str, Any] | None]
) -> Recording:
    """The recording with changes of each segment; those with None are left out."""
    kept = [(one, change(one)) for one in recording.manifest.segments or ()]
    labels = (one.model_copy(update=new) for one, new in kept if new is not None)
    return described(recording, segments=tuple(labels))
