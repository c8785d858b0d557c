"""Which selected candidates form one finding, and which findings can be given a name."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tasks.explain.explanation import UNNAMED
from tasks.explain.search.fitted import is_at_bound
from tasks.explain.search.stepwise import Selected, Selection
from tasks.model.model import Model
from tasks.model.term import Column, Term
from tasks.motion.whole import Motion

PER_TURN = "per_turn"  # the shape of what comes so many times a turn
SAME_STEP = 5.0  # s within which jumps are one step, found anew in each triad or gradual


@dataclass(frozen=True)
class FindingGroup:
    """One finding: its name, the terms that model it, and the candidates selected of it."""

    name: str
    terms: tuple[Term, ...]
    selected: tuple[Selected, ...]

    @property
    def random(self) -> bool:
        """Whether it is a random drift, or a random function of its own drive."""
        return self.selected[0].candidate.prior is not None

    @property
    def unlisted(self) -> bool:
        """Whether it is a kind of behaviour in a form that no publication lists."""
        return self.selected[0].candidate.unlisted

    @property
    def nuisance(self) -> bool:
        """Whether every model of such a recording has it."""
        return self.selected[0].candidate.nuisance

    @property
    def known(self) -> bool:
        """Whether its size is known beforehand, so that it cannot be a shadow of something else."""
        return self.absorbed_by is not None or any(one.candidate.known for one in self.selected)

    @property
    def absorbed_by(self) -> str | None:
        return self.selected[0].absorbed_by

    @property
    def parameter_count(self) -> int:
        """What it is charged for: of a random drift one for each candidate."""
        if self.random:
            return len(self.selected)
        return sum(len(one.candidate.own) for one in self.selected if not one.candidate.known)

    @property
    def gain(self) -> float:
        return sum(one.gain for one in self.selected)


def finding_groups(selection: Selection) -> tuple[FindingGroup, ...]:
    """Groups of candidates that form one finding: those of one name, those that compensate for each
    other, those without a name of one term; several steps are jumps.

    If the strongest form of a name was driven to its limit, the finding loses its name; likewise if
    neighbouring orders of a once-per-turn component were selected.
    """
    named: dict[object, list[Selected]] = {}
    for one in selection.selected:
        name = one.candidate.name
        key = one.candidate.term.key if name == UNNAMED else one.group or name
        named.setdefault(key, []).append(one)
    return tuple(_group(_name_of(some), some) for some in named.values())


def _group(name: str, some: Sequence[Selected]) -> FindingGroup:
    terms = {one.candidate.term.key: one.candidate.term for one in some}
    return FindingGroup(name, tuple(terms.values()), tuple(some))


def _name_of(some: Sequence[Selected]) -> str:
    first = some[0].candidate.term
    times = [one.candidate.term.at[0] for one in some if first.time_course == "jump"]
    several = max(times, default=0.0) - min(times, default=0.0) > SAME_STEP
    doubtful = any(one.candidate.unlisted and UNNAMED in one.rivals for one in some)
    unnamed = several or doubtful or _at_one_place(some) or is_at_bound(first)
    return UNNAMED if unnamed else first.name


def _at_one_place(some: Sequence[Selected]) -> bool:
    """Whether waves of neighbouring orders a turn are the series of something at one place of it.

    What comes N times a turn has that order and its multiples.
    """
    terms = [one.candidate.term for one in some]
    orders = sorted(
        (term.at[1:], term.at[0])
        for term in terms
        if term.shapes[:1] and term.shapes[0].name == PER_TURN
    )
    return any(
        axis == other and lower > 1.0 and higher == lower + 1.0
        for (axis, lower), (other, higher) in pairwise(orders)
    )


def fitted_columns(
    model: Model, groups: Sequence[FindingGroup], motion: Motion
) -> tuple[list[Column], np.ndarray]:
    """Of a model's free parameters, then of known physics in the order of the groups; and what
    the model predicts, (n, 6).
    """
    design = model.linearised(motion, model.free)
    columns = [design.columns[p] for p in np.flatnonzero(model.free).tolist()]
    for term in (term for group in groups for term in group.terms if not term.parameters):
        effect = model.effect_of({term.key}, motion, design.prediction)
        columns.append(dict(enumerate(effect.T)))
    return columns, design.prediction
