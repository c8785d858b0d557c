"""An explanation of readings put right, told of the readings as they were recorded.

A setting that is wrong from the first row to the last is undone before anything else is looked
for: what is found then has the units and axes that it ought to have. Here it is put back.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from schemas.discrepancy import Verdict
from schemas.recording import Recording, Stream
from tasks.explain.channels import CHANNELS, EVERY
from tasks.explain.events.settings import Setting
from tasks.explain.explanation import Explanation, Finding
from tasks.model.effect import EVENTS


def put_right(recording: Recording, settings: Sequence[Setting]) -> Recording:
    """The recording as right settings would have made it."""
    if not settings:
        return recording
    readings = recording.imu.stack(CHANNELS)
    for setting in reversed(settings):
        readings = setting.undone(readings)
    present = {name: readings[:, c] for c, name in enumerate(CHANNELS)
               if name in recording.imu.columns}  # fmt: skip
    columns = {**recording.imu.columns, **present}
    return replace(recording, imu=Stream(recording.imu.t, columns))


def with_settings(
    explanation: Explanation, recording: Recording, settings: Sequence[Setting]
) -> Explanation:
    """The explanation of a recording that was put right, with the settings as its first findings.

    The standard's scale factors take a setting up whole: against the fitted model it leaves no
    mismatch, and its evidence is that no working unit has such scale factors.
    """
    if not settings:
        return explanation
    t = recording.imu.t
    matrix = _matrix(settings, t[:1])
    place = np.abs(matrix).argmax(axis=0)  # the channel in which each one is read
    order = place.argsort()
    own: list[Finding] = []
    found = explanation.found
    for setting in settings:
        own.append(_finding(setting, setting.applied(t, found) - found))
        found = setting.applied(t, found)
    names = {CHANNELS[c]: CHANNELS[place[c]] for c in EVERY}
    ratio = {names[name]: value for name, value in explanation.held_out.rms_ratio.items()}
    return replace(
        explanation,
        recording=recording,
        nominal=explanation.nominal @ matrix.T,
        found=found,
        noise=np.abs(matrix) @ explanation.noise,
        p_value=min([explanation.p_value, *(setting.p_value for setting in settings)]),
        verdict="explained" if not explanation.findings else _also_explained(explanation),
        held_out=explanation.held_out.model_copy(update={"rms_ratio": ratio}),
        left_over=explanation.left_over[order],
        findings=(*own, *(_moved(one, matrix, place) for one in explanation.findings)),
        small=tuple(_moved(one, matrix, place) for one in explanation.small),
    )


def _also_explained(explanation: Explanation) -> Verdict:
    return "partly_explained" if explanation.verdict == "unexplained" else explanation.verdict


def _matrix(settings: Sequence[Setting], t: np.ndarray) -> np.ndarray:
    """(6, 6) what the settings make of the readings of each channel."""
    columns = []
    for unit in np.eye(len(CHANNELS)):
        read = unit[None]
        for setting in settings:
            read = setting.applied(t, read)
        columns.append(read[0])
    return np.array(columns).T


def _moved(finding: Finding, matrix: np.ndarray, place: np.ndarray) -> Finding:
    return replace(
        finding,
        channels=tuple(sorted(int(place[c]) for c in finding.channels)),
        contribution=finding.contribution @ matrix.T,
    )


def _finding(setting: Setting, contribution: np.ndarray) -> Finding:
    effect = EVENTS[setting.effect]
    gain = float(-2.0 * np.log(setting.p_value))
    return Finding(
        effect=setting.effect,
        family=effect.family,
        title=effect.title,
        equation=effect.equation,
        source=effect.source,
        channels=setting.channels,
        parameters=setting.parameters,
        contribution=contribution,
        gain=gain,
        delta_bic=gain,
        held_out_gain=0.5 * gain,
        indistinguishable=setting.indistinguishable,
        separated_by=effect.separated_by,
        share=1.0,
    )
