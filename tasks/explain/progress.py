"""Progress of `explain`: the current step and the share of the work that is done."""

from collections.abc import Callable

Progress = Callable[[str, float], None]
"""What is done now, and the share (0 to 1) of the whole that is behind it."""

# By the processor time of recordings of an hour and less, of plants and of real units.
BEHIND = {
    "motion": 0.02, "events": 0.06, "candidates": 0.15, "search": 0.25, "combinations": 0.65,
    "evidence": 0.8,
    "consequences": 0.88, "report": 0.97,
}  # fmt: skip


def silent(step: str, behind: float) -> None:
    """Nobody is told."""


def report_progress(progress: Progress, step: str, share: float = 0.0) -> None:
    """Tells of a step of which a share (0 to 1) is done."""
    order = [*BEHIND.values(), 1.0]
    first = list(BEHIND).index(step)
    progress(step, order[first] + share * (order[first + 1] - order[first]))
