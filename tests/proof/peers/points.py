"""Few points that stand for a run: means over its dwells, in sectors where attitude turns."""

from dataclasses import dataclass

import numpy as np

from tests.proof.peers.observation import Observation

MOST = 320  # points
SECTORS = 8  # of a turn
TURNING = 0.2  # spread of a component of the vertical: a turn, not a tremble
FEWEST = 5  # blocks of a point
UNLABELLED = 10.0  # s
RELAXATIONS_APART = 4.0  # factor between the time constants that make up flicker


@dataclass(frozen=True)
class Points:
    """number: (n,) point of each block, −1 for none. inputs: (m, d) over their ranges; names: of
    them. time: (m,) s. seconds: (m, 6) of data in each. fold: (m,)."""

    number: np.ndarray
    weight: np.ndarray
    inputs: np.ndarray
    names: tuple[str, ...]
    time: np.ndarray
    seconds: np.ndarray
    fold: np.ndarray

    def mean(self, courses: np.ndarray, channel: int) -> np.ndarray:
        """(m, k) means of courses (n, k) by the weight of a channel's blocks."""
        rows = self.number >= 0
        weight = self.weight[rows, channel] ** 2
        total = np.bincount(self.number[rows], weight, len(self.time))
        sums = [np.bincount(self.number[rows], c * weight, len(self.time)) for c in courses[rows].T]
        return np.asarray(np.column_stack(sums) / np.maximum(total, 1e-300)[:, None])

    def relaxations(self, whole: float) -> np.ndarray:
        """(m, m) covariance of noise 1/f: relaxations whose time constants are spaced evenly in
        their logarithm, from a second to the length of the run (s)."""
        apart = np.abs(self.time[:, None] - self.time)
        taus = RELAXATIONS_APART ** np.arange(np.log(whole) / np.log(RELAXATIONS_APART))
        return np.asarray(np.log(RELAXATIONS_APART) * sum(np.exp(-apart / tau) for tau in taus))


def inputs_of(observation: Observation) -> np.ndarray:
    """(n, d) inputs of δ at the blocks, each over its range; those that vary."""
    return _scaled(observation)[0]


def _scaled(observation: Observation) -> tuple[np.ndarray, tuple[str, ...]]:
    motion = observation.observed.motion
    courses = {f"ω_{a}": motion.rate[:, i] for i, a in enumerate("xyz")}
    courses |= {f"u_{a}": motion.up[:, i] for i, a in enumerate("xyz")}
    courses["t"] = motion.t
    temperature = motion.recorded.get("temperature", motion.recorded.get("air_temperature"))
    if temperature is not None:
        courses["T"] = temperature
    spans = {name: np.nanmax(series) - np.nanmin(series) for name, series in courses.items()}
    kept = {name: series for name, series in courses.items() if spans[name] > 1e-6}
    scaled = [np.nan_to_num(series) / spans[name] for name, series in kept.items()]
    return np.column_stack(scaled), tuple(kept)


def points_of(observation: Observation) -> Points:
    """The points of a recording; a run without labels is cut into stretches of UNLABELLED."""
    observed = observation.observed
    inputs, names = _scaled(observation)
    number = _numbered(_dwells(observation), observed.motion.up)
    rows, m = number >= 0, int(number.max()) + 1
    count = np.bincount(number[rows], minlength=m)

    def mean(series: np.ndarray) -> np.ndarray:
        return np.asarray(np.bincount(number[rows], series[rows], m) / count)

    weights = [np.bincount(number[rows], w[rows] ** 2, m) for w in observed.weight.T]
    return Points(
        number=number,
        weight=observed.weight,
        inputs=np.column_stack([mean(series) for series in inputs.T]),
        names=names,
        time=mean(observed.t),
        seconds=np.maximum(np.column_stack(weights) / observed.rate, 1e-9),
        fold=np.round(mean(observation.fold)).astype(int),
    )


def _dwells(observation: Observation) -> np.ndarray:
    """(n,) the dwell of each block; −1 in moves and where nothing is known."""
    observed = observation.observed
    usable = (observed.weight[:, list(observation.used)] > 0).all(axis=1)
    held = np.array([each.kind != "transition" for each in observed.segments] + [False])
    dwell = np.where(usable & held[observed.segment], observed.segment, -1)
    if (dwell >= 0).any():
        return dwell
    return np.where(usable, (observed.t // UNLABELLED).astype(int), -1)


def _numbered(dwell: np.ndarray, up: np.ndarray) -> np.ndarray:
    """(n,) the point of each block: its dwell, and the sector of the turn; −1 for none."""
    numbers = np.unique(dwell[dwell >= 0])
    sectors = int(np.clip(MOST // max(len(numbers), 1), 1, SECTORS))
    label = np.full(len(dwell), -1)
    for k in numbers:
        rows = np.flatnonzero(dwell == k)
        label[rows] = k * SECTORS + _sector(up[rows], sectors)
    _, place, counts = np.unique(label, return_inverse=True, return_counts=True)
    kept = (label >= 0) & (counts[place] >= FEWEST)
    number = np.full(len(dwell), -1)
    number[kept] = np.unique(label[kept], return_inverse=True)[1]
    return number


def _sector(up: np.ndarray, sectors: int) -> np.ndarray:
    """(n,) sector of the turn that the vertical (n, 3) makes in the body; 0 where it is still."""
    moved = up - up.mean(axis=0)
    _, spread, plane = np.linalg.svd(moved, full_matrices=False)
    if sectors < 2 or spread[min(1, len(spread) - 1)] < TURNING * np.sqrt(len(up)):
        return np.zeros(len(up), int)
    angle = np.arctan2(moved @ plane[1], moved @ plane[0])
    return np.asarray(np.floor((angle + np.pi) / (2.0 * np.pi) * sectors).astype(int) % sectors)
