"""Of names that fit as well as one another, the one that asks for less.

The special case stands before the effect that holds it, and what a working unit may have before
what is beyond that. What the other earns beyond it must exceed the error of its own form.
"""

from collections.abc import Iterator, Sequence

from tasks.explain.confounding.combinations import Combination, chi2_of, dispersion_of, price_of
from tasks.explain.confounding.linear_forms import marked
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.odds import as_likely_within
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.special_case import special_cases
from tasks.explain.search.stepwise import Selected


def with_preferred(fit: FittedSelection, candidates: Sequence[Candidate]) -> FittedSelection:
    """The selection with a rival in the place of what asks for more, where that fits no worse.

    candidates: all that were tried. The rivals of what is replaced are those of its replacement.
    """
    for one in fit.selection.selected:
        parts = [each for each in fit.selection.selected
                 if each.candidate.term.key == one.candidate.term.key]  # fmt: skip
        if not parts:
            continue  # replaced with another part
        found = Combination(tuple(part.candidate for part in parts), fit)
        left = None
        for rival in _asking_for_less(one, found, candidates):
            left = left or _dispersion(one, fit)
            beside = [each for each in fit.selection.selected if each.candidate.name == rival.name]
            without = fit.without([*parts, *beside])
            instead = Combination.of((rival,), (rival.name,), without)
            dearer = price_of(fit) * (instead.fitted_count - found.fitted_count)
            worse = (instead.chi2 - found.chi2) / left
            gain = (chi2_of(without.model, without) - instead.chi2) / left
            if instead.plausible and worse + dearer < as_likely_within(gain):
                tried = one.candidate.name, *one.rivals
                others = tuple(name for name in tried if name != rival.name)
                fit = marked(instead, (), others)
                break
    return fit


def _dispersion(one: Selected, fit: FittedSelection) -> float:
    """Of what is left, in all readings or between the parts of the recording that tell of it."""
    evidence, key = Evidence.of(fit), one.candidate.term.key
    number = next(
        n for n, group in enumerate(evidence.groups) if key in {term.key for term in group.terms}
    )
    return max(dispersion_of(fit), evidence.scatter.dispersion(number))


def _asking_for_less(
    one: Selected, found: Combination, candidates: Sequence[Candidate]
) -> Iterator[Candidate]:
    """In whole forms: its special cases, and its rivals where it is not plausible."""
    candidate = one.candidate
    if candidate.nuisance or candidate.known or candidate.prior is not None or one.absorbed_by:
        return
    names = dict.fromkeys(special_cases(candidate.term))
    if not found.plausible:
        names |= dict.fromkeys(one.rivals)
    for name in names:
        yield from [each for each in candidates if each.is_form_of((name,))][:1]
