"""What an explanation left open: effects it could not tell apart, or only suspected."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import Recording
from tasks.experiment.choose import NOTHING
from tasks.explain.confounding.compare import HOLDS
from tasks.explain.confounding.families import DELAYING, GYROS_ALONE
from tasks.explain.evidence.determination import undetermined
from tasks.explain.explain import explain, fitted_effects
from tasks.explain.explanation import UNNAMED, Explanation
from tasks.explain.progress import Progress, silent
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.refit import fitted
from tasks.model.effect import EVENTS
from tasks.model.model import Model

COVERAGE = 2.0  # standard uncertainties in U
SUSPECTED = ("undetermined", "channel_worse", "overshadowed", "incomplete", "reference_noise")


@dataclass(frozen=True)
class OpenQuestion:
    """names: of the competing effects; one alone competes with none. models: of each, fitted to the
    recording with everything else that was named, which the others are. fit: of the first.
    """

    names: tuple[str, ...]
    models: Mapping[str, Model]
    fit: FittedSelection
    others: tuple[str, ...] = ()


def open_question(
    recording: Recording, asked: Sequence[str] = (), progress: Progress = silent
) -> OpenQuestion | None:
    """The effects that were asked for, else what the recording's explanation left open first.

    None where it names everything by itself. Raises Unusable for what the recording cannot show.
    """
    explanation = explain(recording, progress=progress)
    names = tuple(asked) or next(_open(explanation), ())
    if not names:
        return None
    others = [name for name in _named_alone(explanation) if name not in names]
    if len(names) > 1 and GYROS_ALONE not in names and set(names) <= set(DELAYING):
        others.append(GYROS_ALONE)  # triads may be late unlike each other, whatever makes them late
    fits = {name: fitted_effects(recording, [name, *others]) for name in names}
    models = {name: fit.model for name, fit in fits.items()}
    first = fits[names[0]]
    if len(names) == 1:
        models = {names[0]: _sized(first, names[0])}
        keys = {key for key in first.model.places if key[0] == names[0]}
        models[NOTHING] = models[names[0]].without(keys)
    return OpenQuestion(names, models, first, tuple(others))


def _open(explanation: Explanation) -> Iterator[tuple[str, ...]]:
    findings = (*explanation.findings, *explanation.small)
    for finding in findings:
        if len(finding.group) > 1:
            yield finding.group
        elif finding.indistinguishable and finding.effect != UNNAMED:
            # An event in the samples has no model; what it may be mistaken for has.
            others = (name for name in finding.indistinguishable if name not in EVENTS)
            yield (finding.effect, *others)
    for finding in findings:
        if finding.refusal is not None and finding.refusal.kind in SUSPECTED:
            name = finding.refusal.name
            yield (name, HOLDS[name]) if name in HOLDS else (name,)


def _sized(fit: FittedSelection, name: str) -> Model:
    """With what the recording determines of the effect; where that is nothing, with the clearest
    of its parameters as large as its U. Of several that compete nobody knows what of each is there:
    by what they differ is what the recording does not show.
    """
    model = fit.model
    own = [p for key, place in model.places.items() if key[0] == name for p in _range(place)]
    loose = undetermined(model, [set(own)], np.ones(len(model.values)))
    sized = fitted(model.held_at_zero(loose), fit.blocks, fit.noises)
    values = sized.values.copy()
    for p in own:
        if not loose[p]:
            least = COVERAGE * sized.u[p]
            values[p] = np.copysign(max(abs(values[p]), least), values[p])
    return replace(sized, values=values, free=model.free)


def _range(place: slice) -> range:
    return range(place.start, place.stop)


def _named_alone(explanation: Explanation) -> list[str]:
    return [
        one.effect
        for one in explanation.findings
        if one.effect != UNNAMED and one.terms and not one.group
    ]
