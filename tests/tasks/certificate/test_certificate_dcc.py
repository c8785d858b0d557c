"""The Digital Calibration Certificate: valid by the published schemas, and nothing is lost."""

import base64
import os
from pathlib import Path

import pytest
from lxml import etree
from sample_certificate import certificate

from schemas.certificate import Certificate
from tasks.certificate.faces import faces_of

SCHEMAS = Path(os.environ.get("MIMUCAL_DCC_SCHEMA", "../shared/dcc"))
NAMES = {"dcc": "https://ptb.de/dcc", "si": "https://ptb.de/si"}
needs_schemas = pytest.mark.skipif(not SCHEMAS.is_dir(), reason="the DCC schemas are not here")


@needs_schemas
def test_the_dcc_is_valid_by_the_schema() -> None:
    schema = etree.XMLSchema(etree.parse(SCHEMAS / "v3.3.0" / "dcc.xsd"))
    schema.assertValid(etree.fromstring(faces_of(certificate(), None).dcc))


def test_the_record_lies_in_the_dcc_whole() -> None:
    faces = faces_of(certificate(), None)
    (data,) = etree.fromstring(faces.dcc).findall(
        ".//dcc:statement/dcc:data/dcc:byteData/dcc:dataBase64", NAMES
    )
    assert base64.b64decode(data.text) == faces.record
    assert Certificate.model_validate_json(faces.record) == certificate()
