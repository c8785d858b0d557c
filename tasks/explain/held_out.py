"""What a model predicts of segments that its fit did not see: every other segment, both ways."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tasks.explain.observed import Observed
from tasks.explain.pool import inverse
from tasks.explain.refit import Equations, equations_of
from tasks.explain.spectrum import Noise
from tasks.model.term import Column

CHUNK = 30.0  # s of what has no segments


@dataclass(frozen=True)
class HalfSeen:
    """Whitened Gram matrices of the two halves of a recording, columns and misfit of one model."""

    halves: tuple[Equations, Equations]

    def chi2(
        self, kept: Sequence[int], added: np.ndarray, prior: np.ndarray
    ) -> np.ndarray:
        """Chi-squared (6,) of each half predicted by a fit to the other.

        kept: the columns that are fitted. added: (q,) what is put back into the misfit of the
        columns that are not. prior: (q,) precision beforehand, of changes about `added`.
        """
        total = np.zeros(6)
        for seen, hidden in (self.halves, self.halves[::-1]):
            normal, right, _ = seen.normal()
            right = right + normal @ added
            rows = list(kept)
            block = normal[np.ix_(rows, rows)] + np.diag(prior[rows])
            change = np.zeros(seen.count)
            change[rows] = inverse(block) @ right[rows]
            for channel, (gram, which) in enumerate(zip(hidden.grams, hidden.which, strict=True)):
                combined = np.append((added - change)[which], 1.0)
                total[channel] += combined @ gram @ combined
        return total


def half_seen(
    columns: Sequence[Column], misfit: np.ndarray, observed: Observed, noises: Sequence[Noise]
) -> HalfSeen:
    """The two halves: segments of even and of odd number, with the move before each."""
    even = halves_of(observed)
    return HalfSeen((
        equations_of(columns, misfit, observed, noises, even),
        equations_of(columns, misfit, observed, noises, ~even),
    ))  # fmt: skip


def halves_of(observed: Observed) -> np.ndarray:
    """(n,) bool: rows of every other segment; a move belongs to the segment after it."""
    number = observed.segment
    if (number < 0).all():
        return np.asarray((observed.t / CHUNK).astype(int) % 2 == 0)
    rows = np.flatnonzero(number >= 0)
    following = rows[np.minimum(np.searchsorted(rows, np.arange(len(number))), len(rows) - 1)]
    return np.asarray(number[following] % 2 == 0)
