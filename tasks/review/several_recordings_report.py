"""The result for several recordings of one unit (`mimu-discrepancy/1`)."""

import hashlib
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from schemas.discrepancy import (
    Detection,
    Discrepancy,
    EvidenceFor,
    FoundParameter,
    HeldOut,
    ReportedFinding,
    Verdict,
    Where,
)
from tasks.explain.channels import CHANNELS
from tasks.explain.report.names import parameter_text, sentence
from tasks.explain.report.statements import sentences
from tasks.model.effect import effect_name, separating_recording
from tasks.review.search import FALSE_ALARMS
from tasks.review.several_recordings import FoundTogether
from tasks.words import Sayable, clauses, message, statement
from tasks.words.quantities import plain, probability

MOST_PARAMETERS = 3  # in a sentence
ANSWERS: Mapping[Verdict, str] = {
    "no_mismatch": "together-nothing", "unexplained": "together-unnamed",
    "partly_explained": "together-found", "explained": "together-found",
}  # fmt: skip


def discrepancy_together(
    unit: str,
    found: Sequence[FoundTogether],
    p_value: float,
    alone: Sequence[Discrepancy],
    fitted: Sequence[Discrepancy],
) -> Discrepancy:
    """The answer about recordings of a unit, one entry of `alone` and `fitted` for each.

    alone: what explain says of it by itself; fitted: with the effects found, and no others.
    """
    names = tuple(one.recording_id for one in alone)
    findings = tuple(_finding(one, names, fitted) for one in found)
    verdict = _verdict(found, p_value)
    every = clauses([effect_name(one.effect.name) for one in found])
    more = {"effects": every} if found else {"p": probability(p_value)}
    words = message(ANSWERS[verdict], count=len(names), unit=unit, **more)
    own = [
        message("together-alone", recording=one.recording_id, verdict=one.statement)
        for one in alone
    ]
    return Discrepancy(
        recording_id=" + ".join(names),
        digest=hashlib.sha256("\n".join(one.digest for one in alone).encode()).hexdigest(),
        code_version=alone[0].code_version,
        model=alone[0].model,
        verdict=verdict,
        detection=Detection(p_value=p_value, false_alarm_rate=FALSE_ALARMS),
        explained_share=_mean([one.explained_share for one in fitted]) if found else 0.0,
        left_over=_means([one.left_over for one in fitted]),
        findings=findings,
        held_out=_held_out([one.held_out for one in fitted]),
        remarks=tuple(statement(each) for each in own),
        statement=statement(sentence(words)),
    )


def _verdict(found: Sequence[FoundTogether], p_value: float) -> Verdict:
    if not found:
        return "no_mismatch" if p_value >= FALSE_ALARMS else "unexplained"
    return "partly_explained" if any(one.names for one in found) else "explained"


def held_out_gain(one: FoundTogether, fitted: Sequence[Discrepancy]) -> float:
    """Nats that an effect gains where its values were not taken from: other recordings, or, where
    those say next to nothing of it, the parts of each recording that its own fit did not see.
    """
    if one.held_out is not None:
        return one.held_out
    return sum(each.evidence.held_out_gain_nats for each in _of_effect(one, fitted))


def _of_effect(one: FoundTogether, fitted: Sequence[Discrepancy]) -> list[ReportedFinding]:
    return [each for of in fitted for each in of.findings if each.effect == one.effect.name]


def _finding(
    one: FoundTogether, names: Sequence[str], fitted: Sequence[Discrepancy]
) -> ReportedFinding:
    name = one.effect.name
    of_run = [[f for f in each.findings if f.effect == name][:1] for each in fitted]
    (like,) = next((some for some in of_run if some), (None,))
    parameters = tuple(_parameters(one, names))
    separating = separating_recording(name) if one.names else None
    sizes = tuple(parameter_text(each) for each in parameters[:MOST_PARAMETERS])
    parts: list[Sayable] = [
        message("together-evidence", effect=effect_name(name), gain=plain(one.score)),
        message("review-sizes", sizes=sizes),
    ]
    if one.names:
        others = tuple(effect_name(other) for other in one.names)
        parts.append(message("review-other-names", names=others))
    parts += [message("review-separated-by", recording=separating)] if separating else []
    channels = sorted({c for p in one.effect.parameters for c in p.channels})
    return ReportedFinding(
        effect=name,
        family=one.effect.term.family,
        title=statement(effect_name(name)),
        channels=tuple(CHANNELS[c] for c in channels),
        where=tuple(_where(of_run, names)),
        parameters=parameters,
        evidence=EvidenceFor(
            delta_bic=float(one.score), held_out_gain_nats=held_out_gain(one, fitted)
        ),
        share=_mean([some[0].share if some else 0.0 for some in of_run]),
        homogeneity_p=one.homogeneity_p,
        group=None,
        equation=like.equation if like else "",
        source=like.source if like else "",
        indistinguishable_from=one.names,
        separating_recording=statement(separating) if separating else None,
        next=like.next if like else statement(""),
        statement=statement(sentences([sentence(part) for part in parts])),
    )


def _parameters(one: FoundTogether, names: Sequence[str]) -> Iterator[FoundParameter]:
    """In the units that people read; named with their first recording where each group has its
    own.
    """
    for number, values in enumerate(one.values):
        u = np.sqrt(np.maximum(np.diag(one.covariance[number]), 0.0))
        first = names[int(np.argmax(one.group == number))]
        of_group = f" ({first})" if len(one.values) > 1 else ""
        for p, value, each in zip(one.effect.parameters, values, u, strict=True):
            yield FoundParameter(
                name=p.name + of_group, value=float(value) * p.factor, unit=p.unit,
                u=float(each) * p.factor,
            )  # fmt: skip


def _where(of_run: Sequence[Sequence[ReportedFinding]], names: Sequence[str]) -> Iterator[Where]:
    """Of each recording where it sits, its segments named with it; the shares add up to 1."""
    count = sum(bool(some) for some in of_run)
    for name, some in zip(names, of_run, strict=True):
        for place in (place for each in some for place in each.where):
            segments = tuple(f"{name}/{segment}" for segment in place.segments)
            yield place.model_copy(update={"segments": segments, "share": place.share / count})


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values))


def _means(some: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """The mean of each entry over those that have it."""
    keys = dict.fromkeys(key for each in some for key in each)
    return {key: _mean([each[key] for each in some if key in each]) for key in keys}


def _held_out(some: Sequence[HeldOut]) -> HeldOut:
    return HeldOut(
        rms_ratio=_means([one.rms_ratio for one in some]),
        chi2_per_dof_before=_mean([one.chi2_per_dof_before for one in some]),
        chi2_per_dof_after=_mean([one.chi2_per_dof_after for one in some]),
    )
