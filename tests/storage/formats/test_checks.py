"""What no sensor can have read is refused, with the file, the column and the row."""

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.recording import ANGLE, Stream
from storage.formats.manifest import check_columns, check_stream
from tests.manifests import manifest_of

MANIFEST = manifest_of("r")


@pytest.mark.parametrize("value", [1.1e9, -1e300])
def test_a_reading_beyond_every_sensor_is_refused(value):
    columns = {name: np.zeros(5) for name in ANGLE}
    columns["angle_y"][3] = value
    with pytest.raises(Unusable, match=r"here: column angle_y, row 4: .* no sensor reads"):
        check_stream("here", "imu", Stream(np.arange(5.0), columns))


def test_large_turns_and_pressures_are_readings():
    columns = {name: np.full(5, 1e6) for name in ANGLE}
    check_stream("here", "imu", Stream(np.arange(5.0), columns))
    check_stream("here", "environment", Stream(np.arange(5.0), {"pressure": np.full(5, 1.1e5)}))


def test_the_angle_that_is_missing_is_named():
    with pytest.raises(Unusable, match="column angle_z is missing"):
        check_columns("here", "imu", MANIFEST, {"angle_x", "angle_y"})
