"""A walk walks throughout; what changes at two moments is none."""

import numpy as np

from tasks.explain.evidence.shares import CHANCE, chance_of_largest


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


def test_what_does_not_change_or_is_hardly_known_is_not_judged() -> None:
    assert chance_of_largest(np.zeros(100)) == 1.0
    assert chance_of_largest(np.full(100, np.nan)) == 1.0
