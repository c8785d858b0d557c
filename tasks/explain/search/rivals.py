"""What fits as well in the place of something that was selected.

The price of a search decides what is selected, and not what the data can tell apart: a step has
many instants to be tried at, and between the same rests any of them fits alike. So the instants
are proposed anew in the place of each selected candidate, and rivals are compared by the
chi-squared that they gain and by their parameters alone.
"""

from collections.abc import Sequence
from dataclasses import replace

from tasks.explain.explanation import UNNAMED
from tasks.explain.odds import CERTAIN
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.design import BandedDesign, normal_equations
from tasks.explain.search.proposals import with_proposed_shapes
from tasks.explain.search.scores import ScoredCandidate, rank
from tasks.explain.search.stepwise import Selected, Selection


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
    ranked = rank(normal_equations(design, selection.noises), candidates, rest)
    own = next((each for each in ranked if each.candidate.key == one.candidate.key), None)
    if own is None:
        return ()
    names = dict.fromkeys(each.candidate.name for each in ranked if _fits_as_well(each, own))
    doubtful = (own.candidate.name,) if own.candidate.unlisted else (own.candidate.name, UNNAMED)
    return tuple(name for name in names if name not in doubtful)


def _fits_as_well(other: ScoredCandidate, own: ScoredCandidate) -> bool:
    """By the price of the search, or by the data alone. An unlisted form has its name where the
    odds are CERTAIN; what has no name counts among the others.
    """
    if own.candidate.unlisted:
        return own.fit - other.fit < CERTAIN
    return min(own.score - other.score, own.fit - other.fit) < CERTAIN
