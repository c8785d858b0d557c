"""Labels that are late or early as a whole are put right before anything is compared with them."""

import numpy as np
import pytest

from tasks.explain.inputs.prepared import prepare
from tests.tasks.readings.makers import mistakes
from tests.tasks.readings.makers.bench import bench
from tests.tasks.readings.makers.recorded import recorded


@pytest.mark.parametrize("seconds", [3.0, -7.3])
def test_labels_shifted_as_a_whole_are_put_right_and_told(seconds: float) -> None:
    made = bench(2)
    on_time = [label["t_start"] for label in recorded(made).manifest.model_dump()["segments"]]
    mistakes.labels_late(made, seconds)
    found = prepare(recorded(made))
    starts = [label.t_start for label in found.recording.manifest.segments or ()]
    np.testing.assert_allclose(
        starts, on_time, atol=0.2
    )  # and a few hundredths of a second shorter
    assert any("labels-shifted" in str(remark) for remark in found.full.remarks)
