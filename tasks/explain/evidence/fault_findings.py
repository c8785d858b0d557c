"""States the explanation of repaired readings for the readings as they were recorded.

A fault that is there from the first row to the last is undone before anything else is looked for:
what is found then has the units, axes and codes that it ought to have. Here it is put back.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from schemas.discrepancy import Verdict
from schemas.recording import Recording
from tasks.explain.channels import CHANNELS, EVERY
from tasks.explain.events.code_fault import CodeFault
from tasks.explain.events.faults import Fault
from tasks.explain.evidence.event_findings import event_finding
from tasks.explain.evidence.shares import without_form_errors
from tasks.explain.explanation import Explanation, Finding


def put_right(recording: Recording, faults: Sequence[Fault]) -> Recording:
    """The recording as it would have been without the faults."""
    if not faults:
        return recording
    readings = recording.imu.stack(CHANNELS)
    for fault in reversed(faults):
        readings = fault.undone(readings)
    right = {c: readings[:, k] for k, c in enumerate(CHANNELS) if c in recording.imu.columns}
    return replace(
        recording, imu=replace(recording.imu, columns={**recording.imu.columns, **right})
    )


def with_faults(
    explanation: Explanation, recording: Recording, faults: Sequence[Fault]
) -> Explanation:
    """The explanation of a recording that was put right, with the faults as its first findings.

    The standard's scale factors take a setting up whole: against the fitted model it leaves no
    mismatch, and its evidence is that no working unit has such scale factors.
    """
    if not faults:
        return explanation
    t, found, own = recording.imu.t, explanation.found, list[Finding]()
    matrix = _matrix(faults, t)
    place = np.abs(matrix).argmax(axis=0)  # the channel in which each one is read
    noise = np.abs(matrix) @ explanation.noise
    for fault in faults:
        read = fault.applied(t, found)
        own.append(_finding(fault, read - found, noise))
        found = read
    names = {CHANNELS[c]: CHANNELS[place[c]] for c in EVERY}
    ratio = {names[name]: value for name, value in explanation.held_out.rms_ratio.items()}
    moved = [_moved(one, matrix, place) for one in explanation.findings]
    return replace(
        explanation,
        recording=recording,
        nominal=explanation.nominal @ matrix.T,
        found=found,
        noise=noise,
        p_value=min([explanation.p_value, *(fault.p_value for fault in faults)]),
        verdict=_verdict(explanation),
        held_out=explanation.held_out.model_copy(update={"rms_ratio": ratio}),
        left_over=explanation.left_over[place.argsort()],
        explained_share=explanation.explained_share if explanation.findings else 1.0,
        findings=(*own, *without_form_errors(moved, own)),
        small=tuple(_moved(one, matrix, place) for one in explanation.small),
        determined=explanation.determined and replace(explanation.determined, axes=matrix),
    )


def _verdict(explanation: Explanation) -> Verdict:
    """What becomes of a verdict when a fault is explained besides."""
    if explanation.verdict == "no_mismatch":
        return "explained"
    return "partly_explained" if explanation.verdict == "unexplained" else explanation.verdict


def _matrix(faults: Sequence[Fault], t: np.ndarray) -> np.ndarray:
    """(6, 6) effect of the settings on the readings of each channel."""
    read = np.eye(len(CHANNELS))  # a row for each channel that reads one
    for fault in faults:
        if not isinstance(fault, CodeFault):
            read = fault.applied(t, read)
    return read.T


def _moved(finding: Finding, matrix: np.ndarray, place: np.ndarray) -> Finding:
    return replace(
        finding,
        channels=tuple(sorted(int(place[c]) for c in finding.channels)),
        contribution=finding.contribution @ matrix.T,
    )


def _finding(fault: Fault, contribution: np.ndarray, noise: np.ndarray) -> Finding:
    """The finding of a fault; the offset of wrong codes is compared with the noise (6,)."""
    gain = float(-2.0 * np.log(fault.p_value))
    if isinstance(fault, CodeFault):
        gain = float(np.nansum((contribution / np.where(noise > 0, noise, np.inf)) ** 2))
    return replace(event_finding(fault, contribution, gain), share=1.0)
