"""Peer 1: means of the residuals, segment by segment, against what noise makes of them.

The standard's model is fitted by least squares. A segment whose mean residual is beyond so many
standard deviations of its noise (Allan variance: angle random walk and bias instability) is told.
It names nothing and models nothing.
"""

import numpy as np

from tests.proof.peers.observation import CHANNELS, Observation
from tests.proof.peers.peer import UNNAMED, Answer, Located

THRESHOLD = 3.7  # standard deviations
FEWEST = 5  # blocks of a segment


def residual_threshold(observation: Observation) -> Answer:
    """Which segments of which channels are off."""
    beyond = deviations(observation)
    statistic = float(np.nanmax(beyond, initial=0.0))
    located = []
    for c in observation.used:
        over = np.flatnonzero(beyond[:, c] > THRESHOLD)
        if len(over):
            names = tuple(observation.observed.segments[k].name for k in over)
            strength = float(beyond[over, c].max())
            words = f"{len(over)} segment means beyond {THRESHOLD:g} standard deviations"
            located.append(Located(CHANNELS[c], "level", words, strength, names))
    located.sort(key=lambda one: -one.strength)
    return Answer(statistic, THRESHOLD, tuple(located), (UNNAMED,) if located else ())


def deviations(observation: Observation) -> np.ndarray:
    """(segments, 6) |mean residual| in standard deviations; NaN where there is none."""
    observed = observation.observed
    whole = len(observed.t) / observed.rate
    found = np.full((len(observed.segments), 6), np.nan)
    for number in range(len(observed.segments)):
        rows = observed.segment == number
        for c in observation.used:
            weight = observed.weight[rows, c] ** 2
            if (weight > 0).sum() < FEWEST:
                continue
            mean = float(weight @ observation.left[rows, c] / weight.sum())
            seconds = np.array([weight.sum() / observed.rate])
            found[number, c] = abs(mean) / np.sqrt(observation.noises[c].of_mean(seconds, whole)[0])
    return found
