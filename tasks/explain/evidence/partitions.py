"""Parts of a recording that share no parameters except those of a law."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from tasks.explain.channels import TRIADS
from tasks.explain.explanation import Partition
from tasks.explain.inputs.blocks import Blocks

CHANNEL_COUNT = 6


def partitions(
    blocks: Blocks, cells: np.ndarray, information: np.ndarray
) -> Iterator[tuple[Partition, np.ndarray]]:
    """What divides the recording, and its parts (parts, cells, 6) bool.

    cells: (n,) number of each row's cell. information: (cells,) that each has on the parameters,
    by which time and rate are halved.
    """
    count = len(information)
    edges = np.searchsorted(cells, np.arange(count + 1))
    rate = np.linalg.norm(np.nan_to_num(blocks.motion.rate), axis=1)
    used = np.asarray((blocks.weight > 0).any(axis=1))
    speed, upward = np.zeros(count), np.zeros((count, 3))
    for n, (start, stop) in enumerate(pairwise(edges)):
        rows = slice(start, stop)
        turns = rate[rows] ** 2 * used[rows]
        speed[n] = np.sqrt(turns.sum() / max(1, int(used[rows].sum())))
        upward[n] = np.abs(np.nan_to_num(blocks.motion.up[rows])).sum(axis=0)
    first = _first_half(np.arange(count), information)
    yield "time", _of_cells(first, ~first)
    slow = _first_half(np.argsort(speed, kind="stable"), information)
    yield "rate", _of_cells(slow, ~slow)
    known = upward.any(axis=1)
    yield "up", _of_cells(*(known & (upward.argmax(axis=1) == axis) for axis in range(3)))
    channels = np.arange(CHANNEL_COUNT)
    every = np.ones((count, 1), bool)
    yield "triad", np.stack([every & np.isin(channels, triad) for triad in TRIADS])
    yield "axis", np.stack([every & (channels % 3 == axis) for axis in range(3)])


def _first_half(order: np.ndarray, information: np.ndarray) -> np.ndarray:
    """(cells,) bool: those that come first in an order and have half of the information."""
    share = np.empty(len(order))
    share[order] = np.cumsum(information[order]) - 0.5 * information[order]
    return np.asarray(share <= 0.5 * information.sum())


def _of_cells(*parts: np.ndarray) -> np.ndarray:
    return np.stack([np.repeat(part[:, None], CHANNEL_COUNT, axis=1) for part in parts])
