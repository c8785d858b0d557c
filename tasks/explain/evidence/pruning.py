"""Removes from a selection what does not stand out beside all the rest and the residual."""

from collections.abc import Collection
from dataclasses import replace

from tasks.explain.evidence.evidence import Evidence
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.stepwise import FALSE_ALARMS

WRONG_MODEL = 2.0  # φ from which on a random drift may be what the rest of the model lacks


def pruned(fit: FittedSelection, trials: int, kept: Collection[str] = ()) -> Evidence:
    """The fitted selection without findings that the others make unnecessary, or that do not stand
    out from the residual.

    The weakest is removed and the rest fitted again, until all remaining ones are significant.
    trials: number of candidates tried. kept: names that are not removed. The p value of the
    strongest mismatch is relative to the residual, as its evidence is.
    """
    evidence = Evidence.of(fit)
    chance = [1.0] if _searched(evidence) else [fit.selection.p_value]
    while True:
        numbers = [n for n in _searched(evidence) if evidence.groups[n].name not in kept]
        chance += [trials * evidence.chance(n) for n in numbers]
        weak = [n for n in numbers if unsupported(evidence, n, trials)]
        if not weak:
            break
        weakest = min(weak, key=evidence.evidence)
        evidence = Evidence.of(evidence.fit.without(evidence.groups[weakest].selected))
    selection = replace(evidence.fit.selection, p_value=max(min(chance), fit.selection.p_value))
    return replace(evidence, fit=replace(evidence.fit, selection=selection))


def unsupported(evidence: Evidence, number: int, trials: int) -> bool:
    """Whether a finding gains no more than chance would, with so many candidates tried, or
    segments that a fit did not use are not predicted better with it.
    """
    group, held_out_gain = evidence.groups[number], evidence.held_out_gain(number)
    if group.absorbed_by:
        return False
    if group.random and evidence.scatter.dispersion(number) < WRONG_MODEL:
        return held_out_gain <= 0.0  # the search has charged it for its course
    chance = evidence.chance(number) * trials
    return held_out_gain <= 0.0 or chance > FALSE_ALARMS or evidence.delta_bic(number) <= 0.0


def _searched(evidence: Evidence) -> list[int]:
    """The numbers of the findings that are not in every model of such a recording."""
    return [n for n, group in enumerate(evidence.groups) if not group.nuisance]
