"""What has no name: what it is called instead, and why a name of the catalogue was refused."""

from schemas.discrepancy import Where
from tasks.explain.channels import CHANNELS
from tasks.explain.events.event import channel_names
from tasks.explain.explanation import UNNAMED, Finding, Refusal
from tasks.explain.report.names import channel_title, parameter_name
from tasks.model.effect import effect_name
from tasks.words import Message, Sayable, message
from tasks.words.quantities import plain, rough_quantity

USUAL = {"s": "time", "m": "length", "rad": "angle"}  # kinds of causes, by the SI unit
CLEARLY_LARGER = 1.5  # times the limit of what is plausible, from which it is given as a multiple


def title_of(finding: Finding, places: tuple[Where, ...]) -> Sayable:
    """What a finding is called; without a name by its pattern. places: by falling share."""
    if finding.effect != UNNAMED:
        return finding.title
    return message("report-without-name", pattern=pattern_of(finding, places))


def pattern_of(finding: Finding, places: tuple[Where, ...]) -> Sayable:
    """What an unnamed finding follows; where a name was withdrawn, which channels and where."""
    if finding.title and finding.refusal is None:
        return finding.title
    return message(
        "report-pattern", channels=channel_names(finding.channels),
        dimension=places[0].dimension if places else "unknown",
    )  # fmt: skip


def usual_cause(unit: str) -> Message:
    """What an implausible size of a parameter in this SI unit usually means."""
    return message("report-usual", kind=USUAL.get(unit, "scale"))


def refused(refusal: Refusal) -> Message:
    """Why what a finding resembles is not its name, with the numbers that speak against it."""
    arguments = {"effect": effect_name(refusal.name), "parameter": ""}
    if refusal.parameter is not None:
        arguments["parameter"] = parameter_name(refusal.parameter)
    if refusal.kind == "channel_worse":
        channel = "" if refusal.channel is None else channel_title(CHANNELS[refusal.channel])
        return message("report-refused-channel", **arguments, channel=channel)
    if refusal.kind == "inhomogeneous":
        sizes = {"smallest": refusal.smallest, "largest": refusal.largest}
        shown = {key: rough_quantity(value or 0.0, refusal.unit) for key, value in sizes.items()}
        return message(
            "report-refused-inhomogeneous", **arguments, **shown, parts=refusal.parts or "time"
        )
    value, limit = refusal.value or 0.0, refusal.limit or 0.0
    shown = {"value": rough_quantity(value, refusal.unit)}
    shown["limit"] = rough_quantity(limit, refusal.unit)
    if refusal.kind == "undetermined":
        return message("report-refused-undetermined", **arguments, **shown)
    larger = limit * value > 0 and abs(value) > CLEARLY_LARGER * abs(limit)
    return message(
        "report-refused-implausible", **arguments, **shown, larger=int(larger),
        times=plain(value / limit, 2) if larger else "", usual=usual_cause(refusal.unit),
    )  # fmt: skip
