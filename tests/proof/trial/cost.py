"""What it costs to miss the physics: how wrong the certificate is without it and with it found."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from schemas.decision import Verdict

LIMIT = 4.0  # of U: the tightest limits that a test accuracy of 4 to 1 lets anybody judge by
SPREAD = LIMIT / 3.0  # of U: standard deviation of what a unit's values changed by in its service

Values = Mapping[str, tuple[float, float]]  # value and U by item and element


@dataclass(frozen=True)
class Cost:
    """One case's certificates, beside that of the same run and noise without the effects.

    before, after: the largest error of a value in its own stated U, as the clauses give it and
    with the findings taken off; worst: which one it is before. conforms: whether the unit that is
    judged conforms; passed_before, passed_after: whether its certificate says so. unnoticed: the
    clauses' own evaluation remarks on no more residuals than it does without the effects.
    """

    before: float
    after: float
    worst: str
    conforms: bool
    verdict_before: Verdict
    verdict_after: Verdict
    unnoticed: bool

    @property
    def wrong_before(self) -> bool:
        """Passed and does not conform, or the other way round; to leave it open is not wrong."""
        return self.verdict_before == ("fail" if self.conforms else "pass")

    @property
    def wrong_after(self) -> bool:
        return self.verdict_after == ("fail" if self.conforms else "pass")


def cost_of(
    clean: Mapping[str, Any] | None,
    read: Mapping[str, Any] | None,
    less: Mapping[str, Any] | None,
    seed: int,
) -> Cost | None:
    """From the certificates without effects, as read, and less what was found (None: nothing was).

    The verdict is that of a recalibration: each value may differ by 4 U (of the clean run) at
    most from the last certificate's. The unit's own change since then is drawn for each value from
    N(0, (4 U/3)²), so that nine units of ten conform; what the effects add goes on top. A value
    whose U has grown beyond the limits is left open.
    None where there is no certificate, or no value that all of them state.
    """
    if clean is None or read is None:
        return None
    true, shown = clean["values"], read["values"]
    mended = shown if less is None else less["values"]
    common = [name for name in true if name in shown and name in mended]
    if not common:
        return None
    before, after = (_errors(true, response, common) for response in (shown, mended))
    known, own = np.array([true[name] for name in common]).T
    changed = np.random.default_rng([seed, 11]).normal(0.0, SPREAD, len(common))

    def judged(response: Values) -> Verdict:
        value, U = np.array([response[name] for name in common]).T
        return _verdict(changed + (value - known) / own, U / own)

    return Cost(
        before=float(before.max()),
        after=float(after.max()),
        worst=common[int(before.argmax())],
        conforms=bool((np.abs(changed) <= LIMIT).all()),
        verdict_before=judged(shown),
        verdict_after=judged(mended),
        unnoticed=read["scatter"] <= clean["scatter"],
    )


def _verdict(moved: np.ndarray, U: np.ndarray) -> Verdict:
    """On changes and U (n,), both in U of the clean run; by JCGM 106 without a guard band.

    A U beyond the limits leaves a value open, unless all of value ± U lies outside.
    """
    outside, open_ = np.abs(moved) > LIMIT, U > LIMIT
    if (outside & ~open_).any() or (np.abs(moved) - U > LIMIT).any():
        return "fail"
    return "inconclusive" if open_.any() else "pass"


def _errors(true: Values, response: Values, names: list[str]) -> np.ndarray:
    """|stated − true|/U of each value."""
    return np.array([abs(response[name][0] - true[name][0]) / response[name][1] for name in names])
