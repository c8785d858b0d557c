"""Effects that runs may have in common: terms of the catalogue, whole and in parts."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from schemas.review import Layout, PooledParameter, PooledTerm
from tasks.explain.search.candidates import parts_of
from tasks.review.earth_rotation import NAME as GROUND

TermIdentity = tuple[str, tuple[float, ...], tuple[str, ...]]


@dataclass(frozen=True)
class Effect:
    """A term with some of its parameters.

    own: numbers of its parameters within the term. trials: how many effects of its name are tried.
    """

    term: PooledTerm
    own: tuple[int, ...]
    trials: int = 1

    @property
    def name(self) -> str:
        return self.term.name

    @property
    def parameters(self) -> tuple[PooledParameter, ...]:
        return tuple(self.term.parameters[q] for q in self.own)

    @property
    def unlikely(self) -> float:
        """Twice the nats that it costs to be one of many of its name, or rare."""
        return 2.0 * math.log(self.trials) + self.term.rarity

    @property
    def one_sided(self) -> bool:
        """Whether none of its parameters can be negative, such as a time constant."""
        return all(parameter.low == 0.0 for parameter in self.parameters)


def identity(term: PooledTerm) -> TermIdentity:
    """By which the same term is recognised in another run."""
    return term.name, term.at, tuple(parameter.name for parameter in term.parameters)


def effects_of(layouts: Iterable[Layout]) -> tuple[Effect, ...]:
    """Every effect of some layouts, each once."""
    terms: dict[TermIdentity, PooledTerm] = {}
    for layout in layouts:
        for term in layout.terms:
            if term.name != GROUND:
                terms.setdefault(identity(term), term)
    effects = [
        Effect(term, part)
        for term in terms.values()
        for part in parts_of([parameter.channels for parameter in term.parameters])
    ]
    counts = Counter(effect.name for effect in effects)
    return tuple(replace(effect, trials=counts[effect.name]) for effect in effects)


def starts_of(layout: Layout) -> Mapping[TermIdentity, int]:
    """Where the parameters of each term begin among those of a layout."""
    starts, at = dict[TermIdentity, int](), 0
    for term in layout.terms:
        starts[identity(term)] = at
        at += len(term.parameters)
    return starts


def members_of(effect: Effect, starts: Mapping[TermIdentity, int]) -> Sequence[int] | None:
    """The numbers of an effect's parameters; None where the layout has no such term."""
    start = starts.get(identity(effect.term))
    return None if start is None else [start + q for q in effect.own]
