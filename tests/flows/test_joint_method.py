"""The joint method as it is ordered: by --method, from any kind of recording."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


@pytest.mark.parametrize("name", ["real/xsens_multiposition", "real/ln100_two_position"])
def test_a_joint_calibration_and_its_certificate_are_ordered_by_method(
    mimucal: Callable[..., Any], shared: Path, name: str
) -> None:
    found = mimucal("calibrate", shared / name, "--method", "joint", "--json")
    assert found.code == 0
    assert found.json["method"] == "joint"
    assert len(found.json["items"]) == 9
    certificate = mimucal("certify", shared / name, "--method", "joint", "--budget", "--json")
    assert certificate.code == 0
    assert certificate.json["verdict"] == "inconclusive"
    assert Path(certificate.json["pdf"]).read_bytes().startswith(b"%PDF")


def test_accumulated_angles_are_sent_to_their_own_method(mimucal, ahrs_clean: Path) -> None:
    refused = mimucal("calibrate", ahrs_clean, "--method", "joint")
    assert refused.code == 2
    assert "--method jjf1536" in refused.err
    assert "Traceback" not in refused.err
