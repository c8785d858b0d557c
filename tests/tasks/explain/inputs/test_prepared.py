"""What is slow to be written is no delay of all stamps."""

from dataclasses import replace

import numpy as np

from tasks.explain.channels import CHANNELS
from tasks.explain.inputs.prepared import prepare
from tests.tasks.explain.inputs.test_blocks import on_a_shaft


def test_samples_that_are_held_are_no_delay() -> None:
    recording = on_a_shaft(0.0)
    held = np.arange(len(recording.imu.t)) // 4 * 4
    columns = {name: recording.imu.columns[name][held] for name in CHANNELS}
    recording = replace(recording, imu=replace(recording.imu, columns=columns))
    found = prepare(recording)
    assert found.delay == 0.0
    assert [event.effect for event in found.events.events] == ["repeated_samples"]
