"""Explains a simulated recording of the proposed procedure: which other names would fit it."""

from collections.abc import Mapping, Sequence

from schemas.base import Unusable
from schemas.recording import Recording
from tasks.experiment.choose import Choice, Experiment
from tasks.explain.explain import explain, fitted_effects
from tasks.explain.explanation import UNNAMED
from tasks.model.model import Model


def rivals_of(
    choice: Choice, experiment: Experiment, name: str, others: Sequence[str]
) -> Mapping[str, Model]:
    """The effects that `explain` cannot separate from one in the proposed recording, or names in
    its place, each fitted to it together with the other effects present.
    """
    planned = experiment.planned(choice.procedure)
    rehearsed = experiment.noise.recording(planned, experiment.models[name])
    found: dict[str, Model] = {}
    for rival in _names_beside(name, rehearsed, others):
        try:
            found[rival] = fitted_effects(rehearsed, [rival, *others]).model
        except Unusable:
            continue  # it does not show that one by itself
    return found


def _names_beside(name: str, rehearsed: Recording, others: Sequence[str]) -> list[str]:
    findings = [
        {one.effect, *one.group, *one.indistinguishable} - {UNNAMED, *others}
        for one in explain(rehearsed).findings
    ]
    own = next((names for names in findings if name in names), None)
    if own is None:
        own = next((names for names in findings if names), set())
    return sorted(own - {name})
