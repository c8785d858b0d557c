"""What an engineer would write about a finding: what, where, why, what else, what to record."""

from collections.abc import Iterable
from math import exp, log

from schemas.discrepancy import Consequence, EvidenceFor, FoundParameter, ReportedFinding
from schemas.text import Statement
from tasks.explain.correction.consequences import moved_by
from tasks.explain.report.names import (
    capital,
    channel_title,
    element_title,
    lower,
    parameter_text,
    shift_text,
    verdict_title,
)
from tasks.model.effect import effect_name
from tasks.words import Message, Sayable, clauses, message
from tasks.words.quantities import percent, plain, power_of_ten, quantities

MAX_PARAMETERS, MAX_PLACES = 3, 2  # in a sentence; tables hold all of them
MAX_POWER = 100  # a power of ten beyond which the size of a probability says no more
EVIDENCE = ((10.0, "very-strong"), (6.0, "strong"), (2.0, "some"))  # Kass and Raftery, JASA 90


def sentences(parts: Iterable[Sayable]) -> Sayable:
    """Several sentences as one text, without the empty ones."""
    return clauses([part for part in parts if part], by="report-sentences")


def finding_statement(finding: ReportedFinding) -> Statement:
    """All that is known about a finding, as one paragraph."""
    parts = (
        what(finding), where(finding), why(finding.evidence), alternatives(finding),
        to_record(finding), on_certificate(finding),
    )  # fmt: skip
    return capital(sentences(parts))


def what(finding: ReportedFinding) -> Sayable:
    """What it is and how large, U with k = 2; for what has no name, what it follows."""
    largest = sorted(finding.parameters, key=_significance, reverse=True)[:MAX_PARAMETERS]
    return message(
        "report-what", title=finding.title, given=len(largest),
        sizes=", ".join(map(parameter_text, largest)), more=len(finding.parameters) - len(largest),
    )  # fmt: skip


def where(finding: ReportedFinding) -> Sayable:
    """The channels and circumstances that hold most of it; empty where nothing was located."""
    largest = sorted(finding.where, key=lambda place: place.share, reverse=True)[:MAX_PLACES]
    places = [
        message("report-place", channel=channel_title(place.channel), share=percent(place.share),
                description=place.description)
        for place in largest
    ]  # fmt: skip
    return message("report-places", places=clauses(places)) if places else ""


def why(evidence: EvidenceFor) -> Message:
    """Why it is believed: what it gains on data the fit did not see, and ΔBIC in plain words."""
    gain, bic = evidence.held_out_gain_nats, evidence.delta_bic
    nats = plain(gain)
    prediction = (
        message("report-predicted", times=times_more_probable(gain), nats=nats)
        if gain > 0
        else message("report-not-predicted", nats=nats)
    )
    return message(
        "report-why", prediction=prediction, bic=plain(bic), evidence=strength_of_evidence(bic)
    )


def strength_of_evidence(delta_bic: float) -> Message:
    """What a gain in the Bayesian information criterion is worth, in words."""
    strength = next((name for least, name in EVIDENCE if delta_bic > least), "none")
    return message(f"report-evidence-{strength}")


def times_more_probable(nats: float) -> Message:
    """e^nats as a number one can read."""
    power = nats / log(10.0)
    if power > MAX_POWER:
        return message("report-more-than-times", number=power_of_ten(MAX_POWER)[1:])
    number = plain(exp(nats), 2) if power < 3 else power_of_ten(round(power))[1:]
    return message("report-times", number=number)


def alternatives(finding: ReportedFinding) -> Sayable:
    """What else would fit this recording as well; empty where nothing would."""
    titles = clauses([*map(effect_name, finding.indistinguishable_from)], by="report-or")
    return message("report-alternatives", effects=titles) if titles else ""


def to_record(finding: ReportedFinding) -> Sayable:
    """What to record to be sure; empty where nothing is needed."""
    recording = finding.separating_recording
    return message("report-to-record", recording=recording) if recording else ""


def on_certificate(finding: ReportedFinding) -> Sayable:
    """The largest of its consequences in U, and the verdicts it changes; empty without any."""
    largest = max(finding.consequences, key=moved_by, default=None)
    parts = [_consequence(largest)] if largest and moved_by(largest) > 0.0 else []
    parts += [
        message("report-verdict-changes", item=lower(element_title(change.item, "")),
                before=verdict_title(change.before), after=verdict_title(change.after))
        for change in finding.verdict_changes
    ]  # fmt: skip
    return sentences(parts)


def _consequence(moved: Consequence) -> Message:
    made = quantities([moved.before, moved.after], moved.U, moved.unit)
    return message(
        "report-moves-most", element=element_title(moved.item, moved.element),
        before=made.text(0), after=made.text(1), times=shift_text(moved),
    )  # fmt: skip


def _significance(parameter: FoundParameter) -> float:
    return abs(parameter.value) / parameter.u if parameter.u > 0 else float("inf")
