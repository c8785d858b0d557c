"""What a peer answers, in the same form for all of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import Dimension

UNNAMED = "unnamed"
SLIGHT = 0.05  # of the strongest evidence


@dataclass(frozen=True)
class Located:
    """Where a peer sees a mismatch. strength: its own statistic there."""

    channel: str
    dimension: Dimension
    description: str
    strength: float
    segments: tuple[str, ...] = ()


@dataclass(frozen=True)
class HeldOut:
    """Segments that the fit did not see, in whitened units: root of the ratio of squared misfits
    after and before, and the log-likelihood gained, nats."""

    rms_ratio: float = 1.0
    gain: float = 0.0


@dataclass(frozen=True)
class Answer:
    """statistic: of the strongest mismatch; above the threshold it is a detection.

    names: of the catalogue or `unnamed`, the clearest first. found: (n, 6) predicted readings at
    the blocks; None: the standard's model as it is.
    """

    statistic: float
    threshold: float
    located: tuple[Located, ...] = ()
    names: tuple[str, ...] = ()
    found: np.ndarray | None = None
    held_out: HeldOut = HeldOut()

    @property
    def detected(self) -> bool:
        return bool(self.statistic > self.threshold)


def in_order(names: Sequence[tuple[float, str]]) -> tuple[str, ...]:
    """Each name once, by falling evidence (of the order of chi-squared).

    What has less than SLIGHT of the strongest's is a fit's residue more often than another
    cause, and gets no name.
    """
    ranked = sorted(names, key=lambda pair: -pair[0])
    return tuple(dict.fromkeys(
        name if size >= SLIGHT * ranked[0][0] else UNNAMED for size, name in ranked
    ))  # fmt: skip
