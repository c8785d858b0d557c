"""Steps that show because a limit took a channel's noise away are no coarse resolution."""

import numpy as np
from made_up import counted, mean_readings, motion, noisy

from tasks.explain.events.detect import events_in_readings
from tasks.explain.events.event import Events
from tasks.explain.events.quantisation import NoiseEstimate, cut_off
from tasks.readings.lattice import Quantiser
from tasks.words import say


def found(noise: float, step: float, scale: float = 1.0) -> Events:
    """Accelerometer z with a part of the others' noise and signal, all in the same steps, m/s²."""
    made = motion(minutes=6.0)
    mean = mean_readings(made)
    readings = noisy(mean, 21)
    readings[:, 5] = scale * mean[:, 5] + noise * (readings[:, 5] - mean[:, 5])
    return events_in_readings(counted(readings, (1e-4, step)), made)


def test_a_channel_that_lost_noise_and_signal_is_a_remark() -> None:
    events = found(0.2, 5e-3, 0.7)
    assert events.events == ()
    assert "the accelerometer z reads 70 % of what its motion gives" in say(
        events.remarks[-1], "en"
    )


def test_a_channel_that_is_quieter_than_the_others_shows_its_resolution() -> None:
    (event,) = found(0.2, 5e-3).events
    assert (event.effect, event.channels) == ("coarse_quantisation", (5,))


def test_a_bias_in_place_of_an_input_is_no_share_of_it() -> None:
    steps = [Quantiser(1e-3, 0.0)] * 3
    estimates = [NoiseEstimate(c, q, 0.1 if c == 0 else 0.7, 0.0) for c, q in enumerate(steps)]
    readings = np.full((100, 6), -0.01)
    assert cut_off(estimates, readings, lambda _: np.full(100, 5e-5)) == {}
    assert cut_off(estimates, np.full((100, 6), 0.7), lambda _: np.ones(100)) == {0: 0.7}
