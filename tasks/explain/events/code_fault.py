"""Codes joined wrongly or with a bit lost: readings are off by multiples of 2ᵇ codes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import FoundParameter
from schemas.recording import Recording, WrongCodes
from tasks.explain.events.event import CHANNELS, UNITS, Event, channel_names
from tasks.explain.events.torn_codes import BYTE, torn_codes
from tasks.model.fit import plain_prediction
from tasks.motion.whole import Motion
from tasks.readings.codes import bug_in_words, size_in_words
from tasks.readings.lattice import quantiser_of
from tasks.words import Message, clauses, message

P_VALUE = 1e-9  # of so many jumps to and fro with nothing between, at most


@dataclass(frozen=True)
class CodeFault(Event):
    """off: (n, 6) what the fault added to each reading."""

    off: np.ndarray

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        return predicted + self.off

    def undone(self, readings: np.ndarray) -> np.ndarray:
        """Readings (n, 6) with the right codes."""
        return readings - self.off


def code_fault(recorded: Recording, right: Recording) -> CodeFault | None:
    """What was put right of the codes of a recording, as an event."""
    if not right.wrong_codes:
        return None
    off = recorded.imu.stack(CHANNELS) - right.imu.stack(CHANNELS)
    return _event(right.wrong_codes, np.nan_to_num(off))


def find_torn_codes(readings: np.ndarray, motion: Motion) -> CodeFault | None:
    """Channels of readings (n, 6) whose high byte is that of the row before."""
    off, found, predicted = np.zeros_like(readings), list[WrongCodes](), None
    for c, reading in enumerate(readings.T):
        quantiser = quantiser_of(reading)
        if quantiser is None:
            continue
        step = quantiser.step
        predicted = plain_prediction(readings, motion) if predicted is None else predicted
        torn = torn_codes(reading / step, predicted[:, c] / step)
        if torn is not None:
            off[:, c] = torn * step
            share, nothing = float(np.mean(torn != 0.0)), np.zeros(len(readings), bool)
            found.append(WrongCodes(CHANNELS[c], "torn", BYTE, BYTE * step, share, nothing))
    return _event(found, off) if found else None


def _event(found: Sequence[WrongCodes], off: np.ndarray) -> CodeFault:
    channels = tuple(dict.fromkeys(CHANNELS.index(one.channel) for one in found))
    parameters = tuple(
        FoundParameter(
            name=f"jump_{one.channel}", value=one.jump, unit=_unit(one), u=1e-6 * one.jump
        )
        for one in found
    )
    texts = tuple(
        message(
            "events-code-fault-at", channel=message(f"channel-{one.channel}"),
            size=size_in_words(one), jump=f"{one.jump:.4g} {_unit(one)}",
            share=f"{100.0 * one.share:.2g}",
        )
        for one in found
    )  # fmt: skip
    bugs = clauses(list(_bugs(found)))
    return CodeFault(
        "code_fault", channels, parameters, P_VALUE,
        message("events-code-fault", channels=texts), off,
        title=message("events-code-fault-title", bugs=bugs, channels=channel_names(channels)),
    )  # fmt: skip


def _bugs(found: Sequence[WrongCodes]) -> Iterator[Message]:
    seen = {(one.bug, one.codes): one for one in found}
    yield from map(bug_in_words, seen.values())


def _unit(one: WrongCodes) -> str:
    return UNITS[CHANNELS.index(one.channel) // 3]
