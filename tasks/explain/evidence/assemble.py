"""From evidence and events to the explanation."""

from collections.abc import Sequence

import numpy as np

from schemas.discrepancy import Verdict
from schemas.recording import Recording
from tasks.explain.events.detect import events_in_residual
from tasks.explain.events.event import Events
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.findings import event_findings, findings_of
from tasks.explain.evidence.reference_deviation import reference_deviation
from tasks.explain.explanation import FITTED, UNNAMED, Explanation, Finding
from tasks.explain.inputs.full_rate import FullRate
from tasks.explain.inputs.reference import ReferencePrediction
from tasks.explain.search.refit import fitted, model_of


def explanation_of(
    recording: Recording,
    full: FullRate,
    events: Events,
    evidence: Evidence,
    reference: ReferencePrediction | None = None,
) -> Explanation:
    """The explanation that a fitted selection is, with the events.

    reference: the prediction by which the readings were reduced to those of an ideal unit.
    """
    fit, t, noise = evidence.fit, full.motion.t, np.sqrt(full.rest_variance)
    standard = fitted(model_of((), fit.blocks), fit.blocks, fit.noises)
    predicted, nominal = fit.model.prediction(full.motion), standard.prediction(full.motion)
    findings = findings_of(evidence, full, predicted)
    if reference is not None:
        findings += reference_deviation(standard, nominal, full, fit)
        nominal = reference.readings
        predicted = predicted + reference.beyond_ideal(full.motion)
    residual = full.readings - events.applied(t, predicted)
    events = events_in_residual(events, t, residual, noise, full.motion)
    findings = [*event_findings(events, full, predicted), *findings]
    findings.sort(key=lambda finding: -finding.gain)
    return Explanation(
        recording=recording,
        nominal=nominal,
        found=events.applied(t, predicted),
        noise=noise,
        p_value=min([fit.selection.p_value, *(event.p_value for event in events.events)]),
        verdict=_verdict(findings),
        held_out=evidence.held_out(),
        findings=tuple(findings),
        remarks=(*full.remarks, *events.remarks),
        model=FITTED if reference is None else reference.model,
    )


def _verdict(findings: Sequence[Finding]) -> Verdict:
    if not findings:
        return "no_mismatch"
    unnamed = [finding.effect == UNNAMED for finding in findings]
    if all(unnamed):
        return "unexplained"
    return "partly_explained" if any(unnamed) else "explained"
