"""Whether a unit stands out from the usual spread of an effect among units.

The forms of one name (orders, time constants) look alike in a run: units that differ in one form
of it make a unit that differs in another no mismatch.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from tasks.review.carriers import BETWEEN_UNITS, Carried, chance
from tasks.review.evidence import at_unit_information
from tasks.review.hypotheses import Effect
from tasks.review.mixed import spreads
from tasks.review.pool import Pool
from tasks.review.windows import rows_of


@dataclass(frozen=True)
class OwnValues:
    """What the units of a pool have of their own; what was found of one form is kept."""

    pool: Pool
    found: dict[tuple[Effect, int], float] = field(default_factory=dict)

    def stands_out(self, one: Carried, tried: int, limit: float) -> bool:
        """Whether a unit's value is beyond the spread that the other units show in other forms.

        tried, limit: how much was tried, and the corrected p value that is believed.
        """
        if one.window.level != "unit":
            return True
        tau = max(
            (self._spread(effect, one.window.carrier) for effect in self._other_forms(one)),
            default=0.0,
        )
        if tau <= one.spread.tau:
            return True
        rows = rows_of(self.pool, one.window)[None]
        spread, _ = next(iter(spreads(one.evidence, (one.spread.sigma,), (tau,), rows)))
        gain = 2.0 * float(spread.gains(rows)[0])
        return chance(one.evidence, spread, gain) * tried < limit

    def _other_forms(self, one: Carried) -> Iterator[Effect]:
        """Whole terms of the same name in another form."""
        for effect in self.pool.effects:
            whole = len(effect.own) == len(effect.term.parameters)
            if whole and effect.name == one.effect.name and effect.term.at != one.effect.term.at:
                yield effect

    def _spread(self, effect: Effect, unit: int) -> float:
        """The likeliest spread between the other units in one form."""
        if (effect, unit) not in self.found:
            self.found[effect, unit] = self._likeliest(effect, unit)
        return self.found[effect, unit]

    def _likeliest(self, effect: Effect, unit: int) -> float:
        others = self.pool.unit != unit
        score, information = self.pool.evidence(effect)
        evidence = at_unit_information(
            score * others[:, None], information * others[:, None, None], self.pool.unit
        )
        if not evidence.size:
            return 0.0
        tried = spreads(evidence, (0.0,), BETWEEN_UNITS, np.zeros((0, len(others)), bool))
        return max((spread for spread, _ in tried), key=lambda each: each.likelihood).tau
