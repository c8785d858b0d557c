"""Gain and cost of the effects of a family in linear form, by the equations of the search."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

from tasks.explain.confounding.combinations import Combination, dispersion_of, price_of
from tasks.explain.confounding.delays import Form
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.scores import joint_gain

# Chi-squared that tells two apart: where ramps are sharp, smoothing the reference makes twenty.
DISTINGUISHABLE = 30.0
FORM = 0.02  # of an effect: what its published equation and a real filter or clock differ by


@dataclass(frozen=True)
class LinearForms:
    """The forms of a family's effects beside everything else that a fit has."""

    names: tuple[str, ...]
    forms: tuple[Form, ...]
    fit: FittedSelection

    def gain(self, members: Form) -> float:
        """Chi-squared that the members take away together."""
        selection = self.fit.selection
        others = [one for one in selection.candidates if one.name not in self.names]
        return joint_gain(selection.equations, members, others)

    @cached_property
    def distinguishable(self) -> float:
        """Chi-squared that separates exact forms: more than the errors of their linear
        equations.
        """
        return max(DISTINGUISHABLE, FORM**2 * self.largest_gain / self.dispersion)

    @cached_property
    def largest_gain(self) -> float:
        """Chi-squared that a form alone takes away."""
        return max(map(self.gain, self.forms))

    @cached_property
    def dispersion(self) -> float:
        """As `dispersion_of` has it, of the fit."""
        return dispersion_of(self.fit)

    @cached_property
    def price(self) -> float:
        """As `price_of` has it, of the fit."""
        return price_of(self.fit)

    @cached_property
    def triads_differ(self) -> bool:
        """Whether gyros and accelerometers have different delays, as linear forms show.

        For filters alone: a long delay and a filter differ in their linear forms already.
        """
        both = next((form for form in self.forms if is_by_triad(form)), None)
        whole = next((form for form in self.forms
                      if form[0].name == "bandwidth" and form is not both), None)  # fmt: skip
        if both is None or whole is None:
            return both is not None
        return self.gain(both) - self.gain(whole) > DISTINGUISHABLE * self.dispersion


def marked(
    chosen: Combination, group: tuple[str, ...], rivals: tuple[str, ...] = ()
) -> FittedSelection:
    """The chosen combination's selection, its members with the names of a group and of rivals."""
    own, selection = keys_of(chosen.members), chosen.fit.selection
    selected = tuple(
        replace(one, group=group, rivals=tuple(dict.fromkeys((*one.rivals, *rivals))))
        if one.candidate.key in own
        else one
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
