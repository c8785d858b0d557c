"""What calibrate says of codes that were wrong, and what it does with them."""

from dataclasses import replace

import numpy as np
import pytest

from schemas.calibration import Calibration
from schemas.recording import Recording, Stream
from storage.formats.folder import read_folder
from tasks.calibrate.calibrate import calibrate
from tasks.specifications.register import specification_for
from tests.shared import shared_path

SIZE = 256


def calibrated(recording: Recording) -> Calibration:
    specification = specification_for(recording.manifest.standard)
    return calibrate(specification, recording, run="", code_version="")


def with_numbers(change: "object", step: float) -> Recording:
    """The plant's run with the numbers of gyro x changed, which it gives in steps."""
    recording = read_folder(shared_path("data/plant/plant_clean"))
    columns = dict(recording.imu.columns)
    numbers = np.rint(columns["gyro_x"] / step).astype(int)
    columns["gyro_x"] = change(numbers) * step  # type: ignore[operator]
    return replace(recording, imu=Stream(recording.imu.t, columns))


STEP = np.radians(1e-3)  # of the plant's gyros


def low_byte_signed(numbers: np.ndarray) -> np.ndarray:
    low = numbers & 0xFF
    return numbers - low + np.where(low >= SIZE // 2, low - SIZE, low)


def test_a_result_with_codes_put_right_is_that_of_the_right_codes_and_says_so():
    clean = calibrated(with_numbers(lambda numbers: numbers, STEP))
    mended = calibrated(with_numbers(low_byte_signed, STEP))
    for name, item in clean.items.items():
        assert mended.items[name].value == pytest.approx(item.value, rel=1e-9, abs=1e-12)
    (remark,) = [each for each in mended.remarks if each.code == "codes_put_right"]
    assert remark.run == "remarks"
    assert "low byte was joined as a signed number" in remark.en
    assert "低字节" in remark.zh
    assert not [each for each in clean.remarks if each.code.startswith("codes_")]


def test_a_bit_that_sticks_makes_the_run_invalid():
    stuck = calibrated(with_numbers(lambda numbers: numbers & ~64, STEP))
    (remark,) = [each for each in stuck.remarks if each.code == "codes_undecided"]
    assert remark.run == "invalid"
    assert stuck.validity.verdict == "invalid"
    assert "always clear" in remark.en
