"""What fits as well in the place of something that was selected.

The price of a search decides what is selected, and not what the data can tell apart: a step has
many instants to be tried at, and between the same rests any of them fits alike. So the instants
are proposed anew in the place of each selected candidate, and rivals are compared by the
chi-squared that they gain and by their parameters alone, beside what the form of the selected one
may lack.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tasks.explain.explanation import UNNAMED
from tasks.explain.odds import CERTAIN, as_likely_within
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.design import BandedDesign, NormalEquations, normal_equations
from tasks.explain.search.proposals import with_proposed_shapes
from tasks.explain.search.scores import ScoredCandidate, projected, rank
from tasks.explain.search.special_case import HOLDS, SHOWN, departure_shown
from tasks.explain.search.stepwise import Selected, Selection
from tasks.model.regression import inverse


def with_rivals(
    selection: Selection, design: BandedDesign, candidates: Sequence[Candidate]
) -> Selection:
    """The selection with the names of the catalogue that fit as well in each one's place.

    candidates: all that were tried.
    """
    selected = tuple(
        replace(one, rivals=_rivals(one, selection, design, candidates))
        for one in selection.selected
    )
    return replace(selection, selected=selected)


def _rivals(
    one: Selected, selection: Selection, design: BandedDesign, candidates: Sequence[Candidate]
) -> tuple[str, ...]:
    """Names other than its own, the best first; of an unlisted form `unnamed` among them."""
    if one.candidate.nuisance or one.candidate.name == UNNAMED:
        return ()
    rest = [other for other in selection.candidates if other.key != one.candidate.key]
    design, candidates = with_proposed_shapes(
        design, candidates, selection.noises, [*rest, one.candidate], beside=rest
    )
    equations = normal_equations(design, selection.noises)
    ranked = rank(equations, candidates, rest)
    own = next((each for each in ranked if each.candidate.key == one.candidate.key), None)
    if own is None:
        return ()
    names = dict.fromkeys(each.candidate.name for each in ranked if _fits_as_well(each, own))
    names.pop(own.candidate.name, None)
    if not own.candidate.unlisted:
        names.pop(UNNAMED, None)
    general = HOLDS.get(own.candidate.name)
    places = next((each for each in candidates if each.name == general), None)
    if places is not None:
        names.pop(places.name, None)
        arm = _values(own.candidate, equations, rest)
        if departure_shown(equations, places, rest, arm) <= SHOWN:
            names[places.name] = None
    return tuple(names)


def _values(one: Candidate, equations: NormalEquations, rest: Sequence[Candidate]) -> np.ndarray:
    """(p,) of all its term's parameters in their own units, fitted beside the rest."""
    left, members = projected(equations, rest), list(one.members)
    values = np.zeros(len(one.term.parameters))
    fitted = inverse(left.normal[np.ix_(members, members)]) @ left.right[members]
    values[list(one.own)] = fitted * left.scale[members]
    return values


def _fits_as_well(other: ScoredCandidate, own: ScoredCandidate) -> bool:
    """By the price of the search, or by the data alone; of an unlisted form, which is free to
    follow its drive, by the data.
    """
    better = own.fit - other.fit
    if own.candidate.unlisted:
        return better < CERTAIN
    return own.score - other.score < CERTAIN or better < as_likely_within(own.gain)
