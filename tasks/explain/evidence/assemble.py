"""Assembles the explanation from evidence and events."""

from collections.abc import Sequence

import numpy as np
from scipy.special import chdtrc

from schemas.discrepancy import FoundParameter, Verdict
from tasks.explain.channels import EVERY
from tasks.explain.events.detect import events_in_residual
from tasks.explain.evidence.determination import determined_model
from tasks.explain.evidence.event_findings import event_findings, with_faults
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.findings import findings_of, scrutinised
from tasks.explain.evidence.form_errors import named_beside
from tasks.explain.evidence.left_over import NEAR_NOISE, REFERENCE_KNOWN, LeftOver, remainder
from tasks.explain.evidence.reference_errors import fitted_to_reference_noise, with_smoothing_error
from tasks.explain.evidence.shares import (
    MOSTLY_NOISE,
    drift,
    small_remainder,
    with_shares,
)
from tasks.explain.explanation import FITTED, UNNAMED, Explanation, Finding
from tasks.explain.inputs.full_rate import FullRate
from tasks.explain.inputs.prepared import Prepared
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.refit import fitted, model_of
from tasks.explain.search.stepwise import FALSE_ALARMS
from tasks.explain.whitening import equations_of
from tasks.model.model import Model
from tasks.model.term import places
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.words import message

MOSTLY = 0.5  # explained share up to which what is left is told as a finding of its own
CLEAR = 3.0  # standard uncertainties from which on a parameter is listed
OTHER = message("explain-other-parameters")


def explanation_of(prepared: Prepared, evidence: Evidence, ordered: bool = False) -> Explanation:
    """The explanation given by a fitted selection, the events and the faults of the logger.

    ordered: exactly these terms were requested, and each is reported whatever the evidence.
    """
    evidence = with_smoothing_error(evidence, prepared)
    full, events, reference = prepared.full, prepared.events.without_added(), prepared.reference
    fit, t, noise = evidence.fit, full.motion.t, np.sqrt(full.rest_variance)
    standard = fitted(model_of((), fit.blocks), fit.blocks, fit.noises)
    predicted, nominal = fit.model.prediction(full.motion), standard.prediction(full.motion)
    to_noise = fitted_to_reference_noise(prepared, standard, evidence)
    scrutinies = scrutinised(evidence)
    determined = determined_model(evidence, scrutinies, full)
    terms = findings_of(evidence, scrutinies, full, determined, to_noise, ordered)
    gains = [max(evidence.together(number), 0.0) for number in scrutinies]
    if reference is not None:
        deviations = reference_deviation(standard, nominal, full, fit)
        terms, gains = terms + deviations, gains + [one.gain for one in deviations]
        nominal = reference.readings
        predicted = predicted + reference.beyond_ideal(full.motion)
    residual = full.readings - events.applied(t, predicted)
    events = events_in_residual(events, residual, noise, full.motion, full.start)
    artefacts = event_findings(events, full, nominal, predicted)
    left, total = artefacts.left, max(sum(gains), 1e-300)
    by_terms = max(left.removed - sum(artefacts.removed), 0.0)
    by_term = [by_terms * gain / total for gain in gains]
    if not ordered:
        nuisances = {group.name for group in evidence.groups if group.nuisance}
        counted = sum(one.gain for one in terms) / max(by_terms, 1e-300)
        unexplained = (left.remaining_by_channel + left.rounded_by_channel) * counted
        named = named_beside(
            terms, artefacts.findings, unexplained, left.chi2_per_degree, noise, nuisances
        )
        terms = [drift(one, full.motion) for one in named]
    findings = with_shares([*artefacts.findings, *terms], [*artefacts.removed, *by_term], left)
    if not ordered:
        # Of what every model has, a part without a name says nothing of the unit: see the remarks.
        common = {t.key for group in evidence.groups if group.nuisance for t in group.terms}
        findings = [
            one for one in findings
            if one.effect != UNNAMED or not one.terms or not common.issuperset(one.terms)
        ]  # fmt: skip
    small = [one for one in findings if not ordered and small_remainder(one, left)]
    reported = [one for one in findings if one not in small]
    mostly = left.explained_share < MOSTLY and not ordered
    if mostly and (rest := remainder(full, artefacts.found, left)):
        reported.append(rest)
    p_value = min([fit.selection.p_value, *(event.p_value for event in artefacts.events.events)])
    explanation = Explanation(
        recording=prepared.recording,
        nominal=nominal,
        found=artefacts.found,
        noise=noise,
        p_value=p_value,
        verdict=_verdict(reported, p_value, left),
        held_out=evidence.held_out(artefacts.per_reading),
        findings=tuple(reported),
        remarks=(*full.remarks, *artefacts.events.remarks),
        model=FITTED if reference is None else reference.model,
        left_over=left.chi2_per_degree,
        explained_share=left.explained_share,
        small=tuple(small),
        determined=determined,
    )
    return with_faults(explanation, prepared, left)


def _verdict(findings: Sequence[Finding], p_value: float, left: LeftOver) -> Verdict:
    """Explained is what has names, and leaves next to noise in every channel."""
    named = [finding for finding in findings if finding.effect != UNNAMED]
    # Where nothing was found, what may be the reference's own errors is no mismatch of the unit.
    known = 1.0 if findings else REFERENCE_KNOWN
    quiet = bool((np.nan_to_num(left.beyond_reference(known)) < MOSTLY_NOISE).all())
    if not findings:
        return "no_mismatch" if quiet and p_value > FALSE_ALARMS else "unexplained"
    if not named:
        return "unexplained"
    complete = bool((np.nan_to_num(left.chi2_per_degree) < NEAR_NOISE).all())
    return "explained" if len(named) == len(findings) and complete else "partly_explained"


def reference_deviation(
    standard: Model, predicted: np.ndarray, full: FullRate, fit: FittedSelection
) -> list[Finding]:
    """The finding that the standard's parameters are not those of the prediction; none: they are.

    standard: the standard's model fitted to the readings less what the prediction has beyond an
    ideal unit. predicted: (n, 6) by it at full rate.
    """
    ideal = Model.of(STANDARD_TERMS)
    count = int(standard.free.sum())
    gain = _chi2(ideal, fit) - _chi2(standard, fit)
    if chdtrc(count, max(gain, 0.0)) > FALSE_ALARMS:
        return []
    return [
        Finding(
            effect=UNNAMED,
            family=UNNAMED,
            title=OTHER,
            equation="models (1) and (2)",
            source="JJF 2003-2022, 5.1 and 5.2",
            channels=EVERY,
            parameters=_clear_deviations(standard, ideal.values),
            contribution=predicted - ideal.prediction(full.motion),
            gain=gain,
            delta_bic=gain - count * float(np.log(fit.blocks.used)),
            held_out_gain=0.5 * gain - count,
        )
    ]


def _chi2(model: Model, fit: FittedSelection) -> float:
    """Of a model on the blocks that the selection is fitted to."""
    blocks = fit.blocks
    misfit = blocks.readings - model.prediction(blocks.motion)
    return equations_of([], misfit, blocks, fit.noises).normal()[2]


def _clear_deviations(standard: Model, ideal: np.ndarray) -> tuple[FoundParameter, ...]:
    """The parameters that clearly deviate, as differences from the prediction's, SI."""
    found = []
    for term, place in zip(STANDARD_TERMS, places(STANDARD_TERMS), strict=True):
        for p, parameter in enumerate(term.parameters, place.start):
            name, u = f"{term.name}_{parameter.name}", float(standard.u[p])
            change = float(standard.values[p] - ideal[p])
            if u > 0 and abs(change) > CLEAR * u:
                found.append(FoundParameter(name=name, value=change, unit=parameter.si, u=u))
    return tuple(found)
