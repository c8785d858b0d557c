"""Statements about a finding: what, where, why, alternatives and the next step."""

from collections.abc import Iterable, Mapping, Sequence
from math import exp, log

from schemas.discrepancy import (
    Consequence,
    EvidenceFor,
    FoundParameter,
    ReportedFinding,
    VerdictChange,
)
from schemas.text import Statement
from tasks.explain.correction.consequences import OVERALL, moved_by
from tasks.explain.events.event import channel_names
from tasks.explain.evidence.findings import MOSTLY_NOISE
from tasks.explain.explanation import CHANNELS, UNNAMED, Finding, Refusal
from tasks.model.term import effect_name
from tasks.specifications.estimate import ITEMS
from tasks.words import Message, Sayable, clauses, known, message, statement
from tasks.words.numbers import (
    USUAL_K,
    Quantities,
    chi2,
    multiple,
    percent,
    plain,
    power_of_ten,
    probability,
    quantities,
    quantity,
    rough_quantity,
)

# Names of channels, elements and quantities with U in the sentences of the report.


def channel_title(channels: str) -> Message:
    """“gyro x” of “gyro_x”; several where an entry of `Where` names several: “gyro_x, gyro_y”."""
    names = channels.split(", ")
    titles = (message(f"channel-{name}") if name in CHANNELS else name for name in names)
    return message("list", entries=tuple(titles))


def short_channel_title(channel: str) -> Message:
    """“accel. x” of “accel_x”, where there is little room."""
    return message(f"channel-{channel}.short")


def element_title(item: str, element: str) -> Sayable:
    """An element of a certificate's item; the item where the element is empty."""
    if item == OVERALL:
        return message("report-whole-certificate")
    if item not in ITEMS:
        return f"{item} {element}".strip()
    defined = ITEMS[item]
    return defined.element_title(element) if element else defined.title


def verdict_title(verdict: str) -> Sayable:
    """“pass”, “fail”, “inconclusive”."""
    id_ = f"conformity-verdict.{verdict}"
    return message(id_) if known(id_) else verdict


def change_title(change: VerdictChange) -> Message:
    """“fail → pass”."""
    before, after = verdict_title(change.before), verdict_title(change.after)
    return message("report-change", before=before, after=after)


def shift_text(moved: Consequence) -> str:
    """By how many U an element of the certificate moves, with its sign; empty where it does not."""
    by = moved.in_U
    return multiple(by) if by else ""


def before_and_after(moved: Consequence) -> Quantities:
    """An element's value without the finding and with it, each that is there with its U."""
    U_before = moved.U if moved.U_before is None else moved.U_before  # of an earlier version
    values = [moved.before, moved.after]
    pairs = zip(values, [U_before, moved.U], strict=True)
    return quantities(values, [None if value is None else U for value, U in pairs], moved.unit)


def capital(phrase: Sayable) -> Message:
    """The text with a capital initial; a symbol stays as it is."""
    return message("initial", text=phrase)


def sentence(phrase: Sayable) -> Message:
    """What stands alone as a sentence, with its full stop."""
    return capital(message("report-sentence", text=phrase))


def lower(phrase: Sayable) -> Message:
    """The text with a lower-case initial; a symbol stays as it is."""
    return message("initial.lower", text=phrase)


def parameter_name(name: str) -> Sayable:
    """“vertical rate” of “vertical_rate”, “gyro x” of “gyro_x”; a symbol stays: “r_x”."""
    for kind in ("parameter-", "channel-", "triad-"):
        if known(kind + name):
            return message(kind + name)
    quantity, _, channel = name.partition("_")
    if channel in CHANNELS and known("parameter-of-" + quantity):
        return message("parameter-of-" + quantity, channel=channel_title(channel))
    channel, _, number = name.rpartition("_")
    if channel in CHANNELS and number.isdigit():
        return message("report-factor", channel=channel_title(channel), number=int(number))
    return name if name[1:2] == "_" else name.replace("_", " ")


def parameter_text(parameter: FoundParameter) -> Message:
    """“vertical rate = (9.66 ± 0.40) °/h”; U = 2 u."""
    size = quantity(parameter.value, USUAL_K * parameter.u, parameter.unit)
    return message("report-parameter", name=parameter_name(parameter.name), size=size)


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


# Describes findings without a name, and why a name of the catalogue was refused.

# Reasons without figures.
PLAIN = ("reference_noise", "placed", "switching")
USUAL = {"s": "time", "m": "length", "rad": "angle"}  # kinds of causes, by the SI unit
LARGER = 1.5  # times the limit of what is plausible, from which it is given as a multiple
FAR_BEYOND = 5.0  # times, from which a unit or range may be wrong: 9.8, 57.3, 1000, powers of two


def title_of(finding: Finding) -> Sayable:
    """What a finding is called; without a name by its pattern, by all names that it may be."""
    if finding.group:
        effects = clauses([*map(effect_name, finding.group)], by="report-or")
        return message("report-one-of", effects=effects)
    if finding.effect != UNNAMED:
        return finding.title
    return message("report-without-name", pattern=pattern_of(finding))


def pattern_of(finding: Finding) -> Sayable:
    """What an unnamed finding follows; where a name was refused, with the channels that do."""
    if finding.refusal is None:
        return finding.title
    channels = channel_names(finding.channels)
    return message("report-pattern", pattern=finding.title, channels=channels)


def setting_suspected(finding: Finding, left_over: Mapping[str, float]) -> bool:
    """Whether an implausible size is likely to be a wrong setting: it is many times the limit, and
    explains nearly everything.

    left_over: χ² per degree of freedom of the residual in each channel.
    """
    if finding.refusal is None or not far_beyond(finding.refusal):
        return False
    return all(left_over.get(CHANNELS[c], 0.0) < MOSTLY_NOISE for c in finding.channels)


def usual_cause(refusal: Refusal) -> Message:
    """Which setting makes a parameter of this unit implausible."""
    return message("report-usual", kind=USUAL.get(refusal.unit, "scale"))


def far_beyond(refusal: Refusal) -> bool:
    """Whether a parameter is many times what is plausible."""
    return _times(refusal) > FAR_BEYOND


def _times(refusal: Refusal) -> float:
    """How many times its limit an implausible parameter is; one where that says nothing."""
    value, limit = refusal.value or 0.0, refusal.limit or 0.0
    return value / limit if value * limit > 0.0 else 1.0


def refused(refusal: Refusal, setting: bool) -> Message:
    """Why a finding does not get the name it resembles, with the figures against it.

    setting: a wrong setting is suspected.
    """
    arguments = {"effect": effect_name(refusal.name), "parameter": ""}
    if refusal.parameter is not None:
        arguments["parameter"] = parameter_name(refusal.parameter)
    if refusal.kind in PLAIN:
        kind, placed = refusal.kind.replace("_", "-"), int(refusal.value or 0)
        return message(f"report-refused-{kind}", effect=arguments["effect"], placed=placed)
    if refusal.kind == "channel_worse":
        channel = "" if refusal.channel is None else channel_title(CHANNELS[refusal.channel])
        return message("report-refused-channel", **arguments, channel=channel)
    if refusal.kind == "inhomogeneous":
        sizes = {"smallest": refusal.smallest, "largest": refusal.largest}
        shown = {key: rough_quantity(value or 0.0, refusal.unit) for key, value in sizes.items()}
        return message(
            "report-refused-inhomogeneous", **arguments, **shown, parts=refusal.parts or "time"
        )
    if refusal.kind in ("overshadowed", "form_error"):
        times, left = plain(refusal.value or 0.0, 2), chi2(refusal.limit or 1.0)
        kind = refusal.kind.replace("_", "-")
        return message(f"report-refused-{kind}", **arguments, times=times, chi2=left)
    value, limit = refusal.value or 0.0, refusal.limit or 0.0
    multiple = _times(refusal)
    if multiple > LARGER:  # it is said how many times as large, in which no sign has a place
        limit = abs(limit)
    shown = {"value": rough_quantity(value, refusal.unit)}
    shown["limit"] = rough_quantity(limit, refusal.unit)
    if refusal.kind == "undetermined":
        return message("report-refused-undetermined", **arguments, **shown)
    return message(
        "report-refused-implausible", **arguments, **shown, larger=int(multiple > LARGER),
        times=plain(multiple, 2),
        usual=usual_cause(refusal) if setting else message("report-usual", kind="alike"),
    )  # fmt: skip
