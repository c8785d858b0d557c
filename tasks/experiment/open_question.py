"""What an explanation left open: effects that it could not tell apart, or only suspects."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import Recording
from tasks.experiment.choose import NOTHING
from tasks.explain.explain import explain, fitted_effects
from tasks.explain.explanation import UNNAMED, Explanation
from tasks.explain.groups.families import DELAYING, GYROS_ALONE
from tasks.explain.progress import Progress, silent
from tasks.explain.search.fitted import FittedSelection
from tasks.model.model import Model

COVERAGE = 2.0  # standard uncertainties in U
SUSPECTED = ("undetermined", "overshadowed", "incomplete", "reference_noise")


@dataclass(frozen=True)
class OpenQuestion:
    """names: of the competing effects; one alone competes with none. models: of each, fitted to the
    recording with everything else that was named. fit: of the first.
    """

    names: tuple[str, ...]
    models: Mapping[str, Model]
    fit: FittedSelection


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
    models = {name: _sized(fit.model, name) for name, fit in fits.items()}
    first = fits[names[0]]
    if len(names) == 1:
        keys = {key for key in first.model.places if key[0] == names[0]}
        models[NOTHING] = models[names[0]].without(keys)
    return OpenQuestion(names, models, first)


def _open(explanation: Explanation) -> Iterator[tuple[str, ...]]:
    findings = (*explanation.findings, *explanation.small)
    for finding in findings:
        if len(finding.group) > 1:
            yield finding.group
        elif finding.indistinguishable and finding.effect != UNNAMED:
            yield (finding.effect, *finding.indistinguishable)
    for finding in findings:
        if finding.refusal is not None and finding.refusal.kind in SUSPECTED:
            yield (finding.refusal.name,)


def _sized(model: Model, name: str) -> Model:
    """With the effect as large as it may well be: no parameter smaller than its U."""
    values = model.values.copy()
    for key, place in model.places.items():
        if key[0] == name:
            U = COVERAGE * model.u[place]
            sign = np.where(values[place] < 0.0, -1.0, 1.0)
            values[place] = sign * np.maximum(np.abs(values[place]), U)
    return replace(model, values=values)


def _named_alone(explanation: Explanation) -> list[str]:
    return [
        one.effect
        for one in explanation.findings
        if one.effect != UNNAMED and one.terms and not one.group
    ]
