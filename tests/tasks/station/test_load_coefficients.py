"""Coefficients on their way into a unit, which answers among the frames it goes on sending."""

import re
from typing import Any

import pytest

from schemas.base import Unusable
from schemas.calibration import Correction
from schemas.station import StationFile
from tasks.station import load_coefficients
from tasks.station.load_coefficients import load_correction
from tests.tasks.station.over_sockets import unit
from tests.tasks.station.sample_stations import sample

LINES = ("$WRITE,84,{C_g[0][1]:+.6f}", "$WRITE,74,{B_g[2]:+.4f}")
SCALE = {"B_g": 0.0174532925}
pytestmark = pytest.mark.real_time


def correction(serial: str = "0001") -> Correction:
    square, row = [[1.0, 0.25, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.0, 0.0, 0.0174532925]
    coefficients: dict[str, Any] = {
        "C_g": {"unit": "1", "value": square}, "B_g": {"unit": "rad/s", "value": row}
    }  # fmt: skip
    return Correction.model_validate({
        "unit": {"manufacturer": "Example", "model": "MIMU", "serial": serial},
        "recording_id": "r", "run": "1", "digest": "d", "method": "jjf2003", "code_version": "0",
        "gravity_m_s2": 9.8, "model": [], "correction": [], "coefficients": coefficients,
        "uncertainty": "GUM",
        "example": {name: [0.0, 0.0, 0.0] for name in ("gyro", "accel", "rate", "force")},
    })  # fmt: skip


def station(url: str, **changes: Any) -> StationFile:
    fields = sample()
    lines = {"lines": LINES, "scale": SCALE, "check": "xor8", "acknowledge": "$OK"} | changes
    return StationFile.model_validate(
        fields | {"unit_link": fields["unit_link"] | {"url": url, "load": lines}}
    )


def test_each_line_is_told_in_the_units_own_units_with_its_check_sum():
    with unit(lambda _: b"$OK\r\n") as (url, document):
        _, lines = load_correction(correction(), station(url))
    assert lines == 2
    assert document == [b"$WRITE,84,+0.250000*63\r\n", b"$WRITE,74,+1.0000*6A\r\n"]


def test_a_unit_that_does_not_acknowledge_a_line_is_told_no_more(monkeypatch):
    monkeypatch.setattr(load_coefficients, "ANSWER_S", 0.3)
    refused = re.escape("did not acknowledge “$WRITE,74,+1.0000*6A” with “$OK”")
    with unit(lambda line: b"$OK" if b"84" in line else b"$ERR") as (url, document):
        with pytest.raises(Unusable, match=refused + r".*acknowledged before it: 1"):
            load_correction(correction(), station(url))
        assert len(document) == 2


@pytest.mark.parametrize(
    ("changes", "serial", "sentence"),
    [({}, "0002", r"of MIMU 0002, but station LAB-1 has MIMU 0001"),
     ({"lines": ["{K_x}"]}, "0001", r"“\{K_x\}” of unit_link.load cannot be written"),
     ({"lines": ["{C_g[3][0]}"]}, "0001", r"cannot be written \(list index out of range\)")],
)  # fmt: skip
def test_what_does_not_fit_is_refused_before_anything_is_told(changes, serial, sentence):
    with pytest.raises(Unusable, match=sentence):
        load_correction(correction(serial), station("socket://127.0.0.1:1", **changes))


def test_a_unit_without_a_description_of_it_is_refused():
    with pytest.raises(Unusable, match="has no load: describe there"):
        load_correction(correction(), StationFile.model_validate(sample()))
