"""What an explanation left open: effects it could not tell apart, or only suspected."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import Recording
from tasks.experiment.choose import NOTHING
from tasks.explain.confounding.delays import DELAYING, GYROS_ALONE
from tasks.explain.evidence.determination import undetermined
from tasks.explain.explain import explain, fitted_effects
from tasks.explain.explanation import UNNAMED, Explanation
from tasks.explain.odds import COVERAGE
from tasks.explain.progress import Progress, silent
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.refit import fitted
from tasks.explain.search.special_case import HOLDS, places_apart
from tasks.model.effect import EVENTS
from tasks.model.model import Model

SUSPECTED = ("undetermined", "channel_worse", "overshadowed", "reference_noise")


@dataclass(frozen=True)
class OpenQuestion:
    """names: of the competing effects; one alone competes with none. models: of each, fitted to the
    recording with everything else that was named, which the others are. fit: of the first.
    typical: as models, but a suspected effect has its expected size; in models it has the smallest
    size that the recording allows.
    """

    names: tuple[str, ...]
    models: Mapping[str, Model]
    typical: Mapping[str, Model]
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
    first = fits[names[0]]
    models = {name: fit.model for name, fit in fits.items()}
    for special, general in HOLDS.items():
        if special in models and general in models:
            models[general] = _apart(models[general], general, models[special], special)
    typical = dict(models)
    if len(names) == 1:
        models = {names[0]: _sized(first, names[0])}
        typical = {names[0]: _typical(first, models[names[0]], names[0])}
    # What is to be named alone has to show beside nothing, too.
    own = {key for key in first.model.places if key[0] == names[0]}
    models[NOTHING] = typical[NOTHING] = models[names[0]].without(own)
    return OpenQuestion(names, models, typical, first, tuple(others))


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
    of its parameters as large as its U.
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


def _typical(fit: FittedSelection, sized: Model, name: str) -> Model:
    """With the root mean square of each parameter, given the recording.

    Beforehand a parameter is normal about zero, and those of one unit are alike: their variance is
    what the determined ones have beyond their own, τ² = mean(v² − u²). Given v ± u the mean is κv
    and the variance κu², κ = τ²/(τ² + u²); of what the recording does not determine, 0 and τ².
    """
    values = sized.values.copy()
    for term in sized.terms:
        if term.name != name:
            continue
        place = sized.places[term.key]
        v, u = fit.model.values[place], fit.model.u[place]
        known = sized.values[place] != 0.0
        units = np.array([parameter.unit for parameter in term.parameters])
        for unit in dict.fromkeys(units[known]):
            own = units == unit
            variance = float(np.mean((v**2 - u**2)[own & known]))
            if variance <= 0.0:
                continue  # as small as the recording allows
            kappa = variance / (variance + u**2)
            power = (kappa * v) ** 2 + kappa * u**2
            values[place] = np.where(own, np.copysign(np.sqrt(power), v), values[place])
    return replace(sized, values=values)


def _apart(model: Model, general: str, of_special: Model, special: str) -> Model:
    """The general effect as a typical departure from its special case: what the recording leaves
    open of it is not what it was fitted to.
    """
    r = next(of_special.values[place] for key, place in of_special.places.items()
             if key[0] == special)  # fmt: skip
    values = model.values.copy()
    for key, place in model.places.items():
        if key[0] == general:
            values[place] = places_apart(r)
    return replace(model, values=values)


def _range(place: slice) -> range:
    return range(place.start, place.stop)


def _named_alone(explanation: Explanation) -> list[str]:
    return [
        one.effect
        for one in explanation.findings
        if one.effect != UNNAMED and one.terms and not one.group
    ]
