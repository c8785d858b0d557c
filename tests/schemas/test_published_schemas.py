"""The published JSON schemas are those of the models, and what is refused is refused."""

import json

import pytest
from pydantic import ValidationError

from schemas.calibration import Calibration
from schemas.publish import FOLDER, PUBLISHED, schema_text
from schemas.recording import Manifest, Mount, Segment, Station
from schemas.tolerance import Limit
from tasks.calibrate.calibrate import calibrate
from tasks.specifications.jjf2003 import JJF2003


@pytest.mark.parametrize("name", sorted(PUBLISHED))
def test_published_schema_has_not_drifted_from_its_model(name):
    published = (FOLDER / f"{name}.json").read_text(encoding="utf-8")
    assert published == schema_text(PUBLISHED[name]), "run python -m schemas.publish"


def test_a_calibration_survives_being_written_and_read(ideal_run):
    calibration = calibrate(JJF2003, ideal_run(), run="r", code_version="v")
    text = calibration.model_dump_json()
    again = Calibration.model_validate_json(text)
    assert again == calibration
    assert again.model_dump_json() == text
    assert json.loads(text)["warnings"] == list(calibration.warnings)


def test_a_manifest_keeps_fields_it_does_not_know():
    manifest = Manifest.model_validate(
        {
            "format": "mimu-recording/1",
            "recording_id": "r",
            "unit": {"manufacturer": "m", "model": "m", "serial": "1", "firmware": "2.1"},
            "station": {"id": "s"},
        }
    )
    assert manifest.model_dump()["unit"]["firmware"] == "2.1"


@pytest.mark.parametrize(
    ("model", "document"),
    [
        (Mount, {"quaternion_wxyz": [1, 1, 0, 0]}),
        (Station, {"id": "s", "latitude_deg": 91}),
        (Station, {"id": "s", "gravity_m_s2": 980.15}),
        (Segment, {"name": "a", "kind": "rate", "t_start": 0, "t_end": 1, "axis": "x"}),
        (Segment, {"name": "a", "kind": "rotation", "t_start": 0, "t_end": 1, "axis": "x"}),
        (Segment, {"name": "a", "kind": "static", "t_start": 1, "t_end": 0}),
        (Limit, {"item": "gyro_bias", "unit": "deg/s"}),
        (Limit, {"item": "gyro_bias", "unit": "deg/s", "lower": 1, "upper": 0}),
        (Limit, {"item": "gyro_bias", "unit": "deg/s", "magnitude": 1, "upper": 2}),
    ],
)
def test_what_makes_no_sense_is_refused(model, document):
    with pytest.raises(ValidationError):
        model.model_validate(document)


def test_a_magnitude_is_a_limit_on_both_sides():
    assert Limit(item="gyro_bias", unit="deg/s", magnitude=0.5).bounds == (-0.5, 0.5)
    assert Limit(item="gyro_bias", unit="deg/s", upper=0.5).bounds == (None, 0.5)
