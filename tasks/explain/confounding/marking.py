"""Marks a selection with the names that the data cannot distinguish from those chosen."""

from collections.abc import Iterable
from dataclasses import replace

from tasks.explain.confounding.combinations import Combination
from tasks.explain.confounding.families import Form
from tasks.explain.search.fitted import FittedSelection


def marked(chosen: Combination, group: tuple[str, ...]) -> FittedSelection:
    """The chosen combination's selection, its members with the names of a group."""
    own, selection = keys_of(chosen.members), chosen.fit.selection
    selected = tuple(
        replace(one, group=group if one.candidate.key in own else one.group)
        for one in selection.selected
    )
    return replace(chosen.fit, selection=replace(selection, selected=selected))


def group_names(best: Form, names: Iterable[tuple[str, ...]]) -> tuple[str, ...]:
    """All the names, those of the best first; empty where there are no others.

    What is as good with the best and something more says nothing of what is more.
    """
    own = names_of(best)
    others = [some for some in names if not set(own) <= set(some)]
    return (
        tuple(dict.fromkeys([*own, *(name for some in others for name in some)])) if others else ()
    )


def is_by_triad(form: Form) -> bool:
    """Whether it is a low-pass of each triad's own."""
    return form[0].name == "bandwidth" and len(form[0].term.parameters) > 1


def names_of(members: Form) -> tuple[str, ...]:
    """The effects' names, each once."""
    return tuple(dict.fromkeys(one.name for one in members))


def keys_of(members: Form) -> set[object]:
    """The candidates' keys."""
    return {one.key for one in members}
