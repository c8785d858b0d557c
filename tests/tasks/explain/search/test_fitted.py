"""Effects that are asked for are fitted beside the noise that they leave."""

import numpy as np
import pytest
from short_run import short_run

from tasks.explain.explain import fitted_effects


@pytest.mark.parametrize("seed", [5, 7])
def test_what_an_effect_reads_is_not_taken_for_noise(seed: int) -> None:
    """A slow effect looks like flicker to whom the standard's model is all there is."""
    run = short_run(seed)
    degc = run.recording.imu.columns["temperature"]
    read = np.outer(degc - degc.mean(), [1e-4, -2e-4, 1e-4, 1e-2, 1e-2, -2e-2])
    clean, warm = (
        fitted_effects(recording, ["temperature_bias"]).noises
        for recording in (run.recording, run.with_signal(read, 60.0))
    )
    for without, beside in zip(clean, warm, strict=True):
        assert beside.white == pytest.approx(without.white, rel=0.03)
        assert 0.5 < beside.flicker / without.flicker < 2.0
