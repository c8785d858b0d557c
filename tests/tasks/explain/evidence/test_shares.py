"""A drift states its size; a walk walks throughout, no faster than units do, in the unit."""

from dataclasses import replace

import numpy as np
import pytest
from engine_run import motion

from tasks.explain.channels import CHANNELS
from tasks.explain.evidence.shares import CHANCE, chance_of_largest, drift
from tasks.explain.explanation import UNNAMED, Finding
from tasks.explain.search.empirical_terms import SLOW_DRIFT
from tasks.motion.pose import Tracking

RUN = motion()


def test_walks_are_said_to_switch_as_seldom_as_stated() -> None:
    rng = np.random.default_rng(17)
    walks = np.cumsum(rng.standard_normal((2000, 400)), axis=1)
    switching = sum(chance_of_largest(walk) < CHANCE for walk in walks)
    assert switching <= CHANCE * len(walks) + 3.0 * np.sqrt(CHANCE * len(walks))


def test_a_signal_that_switches_there_and_back_is_no_walk() -> None:
    t = np.linspace(0.0, 100.0, 5000)
    switched = np.where((t > 36.8) & (t < 61.3), 1.0, 0.0)
    assert chance_of_largest(switched) < 1e-6
    wander = 0.05 * np.cumsum(np.random.default_rng(3).standard_normal(5000)) / np.sqrt(250.0)
    assert chance_of_largest(switched + wander) < CHANCE


def walk(rates: dict[int, float], seed: int = 5) -> Finding:
    """A random walk of q (per √s) in some channels, throughout the run."""
    rng, step = np.random.default_rng(seed), float(RUN.t[1] - RUN.t[0])
    course = np.zeros((len(RUN.t), 6))
    for channel, rate in rates.items():
        course[:, channel] = rate * np.sqrt(step) * np.cumsum(rng.standard_normal(len(RUN.t)))
    return Finding(
        effect="bias_random_walk", family="memory", title="wanders", equation="", source="",
        channels=tuple(rates), parameters=(), contribution=course, gain=500.0, delta_bic=450.0,
        held_out_gain=100.0, terms=(("bias_random_walk", 3),), behaviour="a slow drift",
    )  # fmt: skip


@pytest.mark.parametrize("rates", [{0: 6e-6, 4: 8e-5}, {1: 2e-4}, {0: 1e-5, 1: 1e-5, 2: 1e-5}])
def test_a_drift_states_how_far_and_how_fast_it_wanders(rates: dict[int, float]) -> None:
    one = walk(rates)
    sized = drift(one, RUN)
    assert sized.effect == "bias_random_walk"
    stated = {p.name: p for p in sized.parameters}
    for channel, rate in rates.items():
        rms, wander = (stated[f"{name}_{CHANNELS[channel]}"] for name in ("rms", "rate"))
        assert rms.value == pytest.approx(one.contribution[:, channel].std())
        assert abs(wander.value - rate) < 3.0 * wander.u
        assert wander.unit == ("(rad/s)/sqrt(s)" if channel < 3 else "(m/s2)/sqrt(s)")
    unnamed = replace(one, effect=UNNAMED, title=SLOW_DRIFT)
    assert drift(unnamed, RUN).parameters == sized.parameters


@pytest.mark.parametrize(
    ("rates", "furthest"),
    [({3: 0.06}, "rate_accel_x"), ({2: 4e-3}, "rate_gyro_z"), ({0: 1e-5, 4: 0.05}, "rate_accel_y")],
)
def test_what_wanders_faster_than_any_unit_is_no_walk_of_one(
    rates: dict[int, float], furthest: str
) -> None:
    lost = drift(walk(rates), RUN)
    assert (lost.effect, lost.title) == (UNNAMED, "a slow drift")
    assert lost.refusal is not None
    assert (lost.refusal.kind, lost.refusal.parameter) == ("implausible", furthest)
    assert lost.parameters


def level(amplitude: float, seconds: float) -> Finding:
    """What a slow error of the attitude about one axis of the body makes of gravity."""
    error = amplitude * np.sin(2.0 * np.pi * RUN.t / seconds)[:, None] * np.array([0.3, 0.5, 0.8])
    course = np.hstack([np.zeros((len(RUN.t), 3)), 9.8 * np.cross(error, RUN.up)])
    return replace(walk({3: 1.0, 4: 1.0, 5: 1.0}), contribution=course)


@pytest.mark.parametrize(("amplitude", "seconds"), [(1e-3, 70.0), (2e-3, 130.0), (5e-4, 300.0)])
def test_what_a_slow_error_of_the_references_attitude_would_do_is_not_the_units(
    amplitude: float, seconds: float
) -> None:
    by_poses = replace(RUN, tracking=Tracking(1.0, 1.0, 0.01, 1e-12, 1e-14))
    lost = drift(level(amplitude, seconds), by_poses)
    assert lost.refusal is not None
    assert (lost.effect, lost.refusal.kind) == (UNNAMED, "reference_noise")
    assert drift(walk({3: 8e-5, 4: 8e-5, 5: 8e-5}), by_poses).effect == "bias_random_walk"
    assert drift(walk({0: 6e-6, 4: 8e-5}), by_poses).effect == "bias_random_walk"
    assert drift(level(amplitude, seconds), RUN).effect == "bias_random_walk"  # by no reference
