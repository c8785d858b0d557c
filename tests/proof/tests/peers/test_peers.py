"""Each peer on a clean recording, and on one whose gyros' scale factors grow with the rate."""

from collections.abc import Callable

import numpy as np
import pytest

from tests.proof.peers.answer import PEERS
from tests.proof.peers.observation import Observation
from tests.proof.peers.peer import UNNAMED, Answer
from tests.proof.plant.simulate import Simulated

GYROS = {"gyro_x", "gyro_y", "gyro_z"}
Peer = Callable[[Observation], Answer]


@pytest.fixture(scope="module")
def answers(observation_bent: Observation) -> dict[str, Answer]:
    """Of each peer on the bent scale factors."""
    return {name: peer(observation_bent) for name, peer in PEERS.items()}


@pytest.mark.parametrize("peer", PEERS.values(), ids=list(PEERS))
def test_clean_recording_is_left_alone(peer: Peer, observation_clean: Observation) -> None:
    answer = peer(observation_clean)
    assert not answer.detected
    assert answer.located == answer.names == ()
    assert answer.found is None


@pytest.mark.parametrize("name", PEERS)
def test_bent_scale_factor_is_located_in_the_gyros(name: str, answers: dict[str, Answer]) -> None:
    answer = answers[name]
    assert answer.detected
    assert {each.channel for each in answer.located} == GYROS


@pytest.mark.parametrize("name", ["stepwise_bic", "sindy"])
def test_regressions_name_it_and_predict_unseen_segments_better(
    name: str, answers: dict[str, Answer]
) -> None:
    answer = answers[name]
    assert answer.names[0] == "gyro_scale_nonlinearity"
    assert answer.held_out.gain > 0.0
    assert answer.held_out.rms_ratio < 1.0


@pytest.mark.parametrize("name", ["stepwise_bic", "sindy", "gp_discrepancy"])
def test_what_models_closes_the_gap_to_the_truth(
    name: str, answers: dict[str, Answer], observation_bent: Observation, bent: Simulated
) -> None:
    found = answers[name].found
    assert found is not None
    truth = bent.truth[: 2 * len(found)].reshape(len(found), 2, 6).mean(axis=1)  # 50 Hz, 25 Hz
    known = (observation_bent.observed.weight > 0).all(axis=1)
    left, first = (
        ((truth - one)[known, :3] ** 2).sum() for one in (found, observation_bent.nominal)
    )
    assert left < 0.3 * first


def test_threshold_and_process_name_nothing(answers: dict[str, Answer]) -> None:
    for name in ("residual_threshold", "gp_discrepancy"):
        assert answers[name].names == (UNNAMED,)


def test_threshold_tells_the_segments_with_the_highest_rates(
    answers: dict[str, Answer], observation_bent: Observation
) -> None:
    answer = answers["residual_threshold"]
    (gyro_z,) = (each for each in answer.located if each.channel == "gyro_z")
    dwells = (each for each in observation_bent.observed.segments if each.axis == "z")
    fast = {each.name for each in dwells if abs(each.rate_deg_s or 0.0) == 200.0}
    assert fast
    assert fast <= set(gyro_z.segments)


def test_same_recording_gives_the_same_answer(
    answers: dict[str, Answer], observation_bent: Observation
) -> None:
    for name, peer in PEERS.items():
        first, again = answers[name], peer(observation_bent)
        assert first.statistic == again.statistic
        assert first.located == again.located
        assert (first.found is None) == (again.found is None)
        if first.found is not None and again.found is not None:
            np.testing.assert_array_equal(first.found, again.found)
