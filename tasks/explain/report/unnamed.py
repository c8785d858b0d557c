"""Describes findings without a name, and why a name of the catalogue was refused."""

from collections.abc import Mapping

from tasks.explain.channels import CHANNELS
from tasks.explain.events.event import channel_names
from tasks.explain.evidence.shares import MOSTLY_NOISE
from tasks.explain.explanation import UNNAMED, Finding, Refusal
from tasks.explain.report.names import channel_title, parameter_name
from tasks.model.effect import effect_name
from tasks.words import Message, Sayable, clauses, message
from tasks.words.quantities import chi2, plain, rough_quantity

# Reasons without figures.
PLAIN = ("reference_noise", "placed", "one_end", "both_ways", "swings", "switching")
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
