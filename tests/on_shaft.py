"""The manifest of a run on a shaft with one encoder."""

from schemas.recording import Manifest


def shaft_manifest(*direction: float) -> Manifest:
    """Of a shaft along a direction; its encoder is `a`."""
    return Manifest.model_validate({
        "format": "mimu-recording/1", "recording_id": "shaft",
        "unit": {"manufacturer": "", "model": "", "serial": ""},
        "station": {
            "id": "s", "gravity_m_s2": 9.8,
            "table_axes": [{"name": "a", "direction": list(direction)}],
        },
    })  # fmt: skip
