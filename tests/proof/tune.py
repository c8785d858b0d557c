"""Where the peers' thresholds come from: `python -m tests.proof.tune 0 250`.

Clean recordings are drawn as the trial draws them, from seeds [7201, number] that no trial has;
the 99 % quantile of each peer's statistic is what about 1 % false alarms asks for.
"""

import sys

import numpy as np

from tests.proof.peers.answer import PEERS
from tests.proof.peers.observation import see
from tests.proof.plant.simulate import simulate
from tests.proof.trial.seal import conditions

SEED = 7201


def statistics(number: int) -> list[float]:
    """The statistic of each peer on one clean recording."""
    case = conditions(np.random.default_rng([SEED, number]), ("clean", (), None))
    observation = see(simulate(case).recording)
    return [float(peer(observation).statistic) for peer in PEERS.values()]


if __name__ == "__main__":
    every = np.array([statistics(number) for number in range(*map(int, sys.argv[1:3]))])
    for name, series in zip(PEERS, every.T, strict=True):
        quantiles = np.quantile(series, [0.5, 0.9, 0.99, 1.0])
        print(name, len(series), *(f"{q:.2f}" for q in quantiles))
