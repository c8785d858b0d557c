"""Statements about a finding: what, where, why, alternatives and the next step."""

from collections.abc import Iterable, Mapping, Sequence
from math import exp, log

from schemas.discrepancy import (
    Consequence,
    EvidenceFor,
    FoundParameter,
    ReportedFinding,
)
from schemas.text import Statement
from tasks.explain.correction.consequences import moved_by
from tasks.explain.evidence.shares import MOSTLY_NOISE
from tasks.explain.explanation import UNNAMED
from tasks.explain.report.names import (
    before_and_after,
    capital,
    channel_title,
    element_title,
    lower,
    parameter_text,
    shift_text,
    verdict_title,
)
from tasks.model.effect import effect_name
from tasks.words import Message, Sayable, clauses, message, statement
from tasks.words.quantities import (
    chi2,
    multiple,
    percent,
    plain,
    power_of_ten,
    probability,
)
from tasks.words.rounding import USUAL_K

MAX_PARAMETERS, MAX_PLACES = 3, 2  # in a sentence; tables hold all of them
MAX_POWER = 100  # a power of ten beyond which the size of a probability says no more
EVIDENCE = ((10.0, "very-strong"), (6.0, "strong"), (2.0, "some"))  # Kass and Raftery, JASA 90
DIFFERENT = 0.01  # probability below which parameters differ from part to part by more than chance
NO_GAIN = 0.5  # nats; what gains no more on data that the fit did not see is absorbed
LEAST = 1e-4  # share that is printed: what is found is never nothing
TAKEN_BACK = 0.5  # of a shift: what the other findings take back, from which the set is told


def sentences(parts: Iterable[Sayable]) -> Sayable:
    """Several sentences as one text, without the empty ones."""
    return clauses([part for part in parts if part], by="report-sentences")


def finding_statement(
    finding: ReportedFinding,
    left_over: Mapping[str, float],
    together: Sequence[Consequence],
) -> Statement:
    """All that is known about a finding, as one paragraph that ends in what to do next.

    left_over: χ² per degree of freedom of each channel. together: what all findings move.
    """
    if not finding.share and not finding.evidence.delta_bic:
        left = _nothing_removes(finding, left_over)
        return statement(capital(sentences([what(finding), where(finding), left, to_do(finding)])))
    parts = (
        what(finding), finding.refused or "", where(finding), why(finding.share, finding.evidence),
        other_tests(finding, left_over), alternatives(finding),
        to_record(finding), on_certificate(finding, together), to_do(finding),
    )  # fmt: skip
    return statement(capital(sentences(parts)))


def _nothing_removes(finding: ReportedFinding, left_over: Mapping[str, float]) -> Message:
    """How much stays in each channel of what no finding removes any of."""
    channels = tuple(
        message("report-left-in", channel=channel_title(channel), chi2=chi2(left_over[channel]))
        for channel in finding.channels if channel in left_over
    )  # fmt: skip
    return message("report-nothing-removes", channels=channels)


def what(finding: ReportedFinding) -> Sayable:
    """The identity and size of a finding, by the parameters that exceed their U (k = 2).

    The sizes of a finding that was refused a name are in the reason for the refusal; those of names
    that compensate for each other are meaningless, and what they have in common is stated with the
    names.
    """
    if finding.group:
        return message("report-what", title=finding.title, given=0, sizes=(), more=0)
    shown = 0 if finding.refused else MAX_PARAMETERS
    clear = [each for each in finding.parameters if _significance(each) > USUAL_K]
    largest = sorted(clear, key=_significance, reverse=True)[:shown]
    return message(
        "report-what", title=finding.title, given=len(largest),
        sizes=tuple(map(parameter_text, largest)), more=len(finding.parameters) - len(largest),
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


def why(share: float, evidence: EvidenceFor) -> Message:
    """Why it is believed: what it removes and predicts, and ΔBIC in plain words.

    What the standard's parameters absorb removes nothing: it shows in their values. Nor does what
    is small beside the noise of single readings, of which it takes many.
    """
    gain, bic = evidence.held_out_gain_nats, evidence.delta_bic
    if share < LEAST and abs(gain) < NO_GAIN:
        strength = strength_of_evidence(bic)
        return message("report-why-absorbed", bic=plain(bic), evidence=strength)
    prediction = message("report-not-predicted", nats=plain(gain))
    if gain > 0:
        times = times_more_probable(gain)
        prediction = message("report-predicted", times=times, nats=plain(gain))
    return message(
        "report-why" if share >= LEAST else "report-why-over-many", share=percent(share),
        prediction=prediction, bic=plain(bic), evidence=strength_of_evidence(bic),
    )  # fmt: skip


def other_tests(finding: ReportedFinding, left_over: Mapping[str, float]) -> Sayable:
    """What the other tests of a finding say; empty where none was possible.

    Whether its channels stay above noise all the same, and whether a named law is the same in all
    parts of the recording. left_over: χ² per degree of freedom of each channel.
    """
    return sentences([_stays_high(finding, left_over), _homogeneity(finding)])


def _stays_high(finding: ReportedFinding, left_over: Mapping[str, float]) -> Sayable:
    located = [place.channel for place in finding.where if place.channel in left_over]
    high = {channel: left_over.get(channel, 0.0) for channel in located or finding.channels}
    channel = max(high, key=lambda each: high[each], default="")
    if not channel or high[channel] < MOSTLY_NOISE:
        return ""
    return message("report-stays-high", channel=channel_title(channel), chi2=chi2(high[channel]))


def _homogeneity(finding: ReportedFinding) -> Sayable:
    p = finding.homogeneity_p
    if p is None or finding.refused:
        return ""
    return message(
        "report-homogeneity", p=probability(p), alike=int(p >= DIFFERENT),
        named=int(finding.effect != UNNAMED),
    )  # fmt: skip


def small_statement(title: Sayable, share: float) -> Message:
    """What removes little of the mismatch, in a few words."""
    return message("report-small-finding", title=title, share=percent(max(share, LEAST)))


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
    """What compensates for it here, or would fit this recording as well; empty without either."""
    parts: list[Sayable] = []
    if finding.group:
        common = tuple(map(parameter_text, finding.common))
        effects = either(finding.group)
        parts.append(message("report-group", effects=effects, shared=len(finding.common),
                             common=common))  # fmt: skip
    if others := rivals(finding):
        parts.append(message("report-alternatives", effects=either(others)))
    return sentences(parts)


def rivals(finding: ReportedFinding) -> list[str]:
    """The effects that it cannot be told from, beside those of its group, which its title names."""
    return [name for name in finding.indistinguishable_from if name not in (finding.group or ())]


def either(names: Sequence[str]) -> Sayable:
    """The titles of effects with “or” between them."""
    return clauses([*map(effect_name, names)], by="report-or")


def to_record(finding: ReportedFinding) -> Sayable:
    """What to record to be sure; empty where nothing else would fit as well."""
    recording = finding.separating_recording
    twins = finding.group or finding.indistinguishable_from
    return message("report-to-record", recording=recording) if recording and twins else ""


def to_do(finding: ReportedFinding) -> Sayable:
    """What to do next."""
    return message("report-to-do", next=finding.next)


def on_certificate(finding: ReportedFinding, together: Sequence[Consequence]) -> Sayable:
    """The largest of its consequences in U, and the verdicts it changes; empty without any.

    together: consequences of all findings; those that other findings cancel are stated for the set.
    """
    largest = max(finding.consequences, key=moved_by, default=None)
    joint = finding.jointly_with
    parts = [_consequence(largest, together, joint)] if largest and moved_by(largest) > 0.0 else []
    parts += [
        message("report-verdict-changes", item=lower(element_title(change.item, "")),
                before=verdict_title(change.before), after=verdict_title(change.after))
        for change in finding.verdict_changes
    ]  # fmt: skip
    return sentences(parts)


def _consequence(
    moved: Consequence, together: Sequence[Consequence], joint: Sequence[int]
) -> Message:
    same = [each for each in together
            if (each.item, each.element) == (moved.item, moved.element)]  # fmt: skip
    joined: dict[str, str | int] = {"joint": len(joint), "others": ", ".join(map(str, joint))}
    if sum(each.change for each in same) / moved.change < TAKEN_BACK:
        return message(
            "report-moves-in-set", element=lower(element_title(moved.item, moved.element)),
            times=multiple(moved.in_U), together=multiple(sum(each.in_U for each in same)),
            **joined,
        )  # fmt: skip
    made = before_and_after(moved)
    return message(
        "report-moves-most", element=element_title(moved.item, moved.element),
        before=made.text(0), after=made.text(1), times=shift_text(moved), **joined,
    )  # fmt: skip


def _significance(parameter: FoundParameter) -> float:
    return abs(parameter.value) / parameter.u if parameter.u > 0 else float("inf")
