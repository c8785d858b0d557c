"""Whether a unit stands out of what units have of an effect anyhow, in whichever form.

The forms of one name (orders, time constants) look alike in a run: units that differ in one form
of it make a unit that differs in another no mismatch.
"""

import numpy as np

from tasks.review.carriers import BETWEEN_UNITS, Carried, chance
from tasks.review.mixed import at_unit_information, spreads
from tasks.review.pool import Pool
from tasks.review.windows import rows_of


def stands_out(pool: Pool, one: Carried, tried: int, limit: float) -> bool:
    """Whether a unit's value is beyond the spread that the other units show in other forms.

    tried, limit: how much was tried, and the corrected p value that is believed.
    """
    if one.window.level != "unit":
        return True
    tau = _spread_of_others(pool, one)
    if tau <= one.spread.tau:
        return True
    rows = rows_of(pool, one.window)[None]
    spread, _ = next(iter(spreads(one.evidence, (one.spread.sigma,), (tau,), rows)))
    gain = 2.0 * float(spread.gains(rows)[0])
    return chance(one.evidence, spread, gain) * tried < limit


def _spread_of_others(pool: Pool, one: Carried) -> float:
    """The largest likeliest spread of the other units in the other forms of the name."""
    others = ~(pool.unit == one.window.carrier)
    found = [0.0]
    for effect in pool.effects:
        term = effect.term
        if effect.name != one.effect.name or term.at == one.effect.term.at:
            continue
        if len(effect.own) < len(term.parameters):
            continue
        score, information = pool.evidence(effect)
        evidence = at_unit_information(
            score * others[:, None], information * others[:, None, None], pool.unit
        )
        if evidence.size:
            tried = spreads(evidence, (0.0,), BETWEEN_UNITS, np.zeros((0, len(others)), bool))
            found.append(max((spread for spread, _ in tried), key=lambda s: s.likelihood).tau)
    return max(found)
