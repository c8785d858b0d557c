"""The recommended action for each finding, with or without a name."""

from schemas.discrepancy import Where
from tasks.explain.channels import CHANNELS
from tasks.explain.explanation import UNNAMED, Finding, Refusal
from tasks.explain.report.names import channel_title
from tasks.explain.report.unnamed import far_beyond, usual_cause
from tasks.model.effect import next_step, separating_recording
from tasks.words import Sayable, message


def next_of(finding: Finding, places: tuple[Where, ...], setting: bool) -> Sayable:
    """What an engineer does next: checks a setting, the fixture, the logger, or records something.

    places: by falling share. setting: a wrong setting is suspected.
    """
    if finding.effect != UNNAMED:
        return next_step(finding.effect) or finding.separated_by or _by_place(places)
    if finding.refusal is None:
        return _by_place(places)
    return _after_refusal(finding.refusal, setting) or _by_place(places)


ALIKE_FOR_ALL = {
    "overshadowed": "report-next-overshadowed",
    "incomplete": "report-next-incomplete",
    "scatter": "report-next-incomplete",
    "reference_noise": "report-next-reference-noise",
    "placed": "report-next-placed",
    "one_end": "report-next-one-end",
    "both_ways": "report-next-mode",
    "swings": "report-next-mode",
    "switching": "report-next-switching",
}  # what is next, whatever name was refused


def _after_refusal(refusal: Refusal, setting: bool) -> Sayable | None:
    if refusal.kind == "implausible":
        if setting:
            return message("report-next-implausible", usual=usual_cause(refusal))
        return message("report-next-alike") if far_beyond(refusal) else None
    if refusal.kind == "inhomogeneous":
        return message("report-next-inhomogeneous", parts=refusal.parts or "time")
    if refusal.kind == "channel_worse" and refusal.channel is not None:
        return message("report-next-channel", channel=channel_title(CHANNELS[refusal.channel]))
    if refusal.kind in ALIKE_FOR_ALL:
        return message(ALIKE_FOR_ALL[refusal.kind])
    recording = separating_recording(refusal.name)
    return message("report-next-undetermined", recording=recording) if recording else None


def _by_place(places: tuple[Where, ...]) -> Sayable:
    return message("report-next", dimension=places[0].dimension if places else "level")
