"""Where the peers' thresholds come from.

Clean recordings are drawn as the trial draws them, from seeds [7201, number] that no trial has;
the 99 % quantile of each peer's statistic is what about 1 % false alarms asks for.
"""

import numpy as np

from tests.proof.peers.answer import PEERS
from tests.proof.peers.observation import see
from tests.proof.plant.simulate import simulate
from tests.proof.study import Count, Out, Seed, hold, table
from tests.proof.trial.seal import conditions

SEED = 7201


def statistics(number: int) -> list[float]:
    """The statistic of each peer on one clean recording."""
    case = conditions(np.random.default_rng([SEED, number]), ("clean", (), None))
    observation = see(simulate(case).recording)
    return [float(peer(observation).statistic) for peer in PEERS.values()]


def peer_thresholds(count: Count = 250, seed: Seed = 0, out: Out = None) -> None:
    """Quantiles of each peer's statistic on clean recordings, of the numbers from --seed on."""
    work = {f"{number}": number for number in range(seed, seed + count)}
    hold("peer-thresholds", work, statistics, _page, out)


def _page(found: list[list[float]]) -> str:
    rows = zip(PEERS, np.quantile(found, [0.5, 0.9, 0.99, 1.0], axis=0).T, strict=True)
    columns = ("peer", "50 %", "90 %", "99 %", "most")
    return "\n".join(table(columns, ((name, *(f"{q:.2f}" for q in each)) for name, each in rows)))
