"""An event: an artefact of the readings that is no regressor, and how it changes what is read."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import ClassVar

import numpy as np

from schemas.discrepancy import FoundParameter
from schemas.recording import ACCEL, GYRO
from tasks.explain.channels import TRIADS
from tasks.words import Argument, Message, Sayable, message

CHANNELS = GYRO + ACCEL
UNITS = ("rad/s", "m/s2")  # of a triad
TRIAD_NAMES = (message("triad-gyro"), message("triad-accel"))


@dataclass(frozen=True)
class Event:
    """An artefact of the readings. A subclass says how it changes them.

    effect: its catalogue name, or `unnamed`. channels: 0 to 5, those affected.
    p_value: corrected for the number of hypotheses tested. linear: a small signal passes
    unchanged. indistinguishable: catalogue names that do the same to these readings. title: where
    more is to be said than the catalogue's.
    """

    linear: ClassVar[bool] = True

    effect: str
    channels: tuple[int, ...]
    parameters: tuple[FoundParameter, ...]
    p_value: float
    description: Message
    indistinguishable: tuple[str, ...] = field(default=(), kw_only=True)
    title: Sayable = field(default="", kw_only=True)

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        """The mean readings (n, 6) with the event, given those predicted (n, 6) without it.

        t: (n,) s.
        """
        return predicted

    def sampled_at(self, t: np.ndarray) -> np.ndarray:
        """When the readings stamped t (n,) s were taken, s."""
        return t

    def noise_floor(self, noise: np.ndarray) -> np.ndarray:
        """The noise (n, 6), at least that which the event itself makes."""
        return noise

    def corrected(self, readings: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
        """The readings (n, 6) without the event, NaN where they carry no information on that.

        before, after: what was predicted without the event and with it.
        """
        return readings - (after - before)


@dataclass(frozen=True)
class AddedSignal(Event):
    """An event that adds to the readings: each of its signals is (n, 6) at times (n,) s.

    frequencies: Hz, of signals that are steady lines.
    """

    signals: tuple[Callable[[np.ndarray], np.ndarray], ...]
    frequencies: tuple[float, ...] = field(default=(), kw_only=True)

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        return predicted + sum(signal(t) for signal in self.signals)


@dataclass(frozen=True)
class Events:
    """All events of a recording, in the order in which they act on a reading.

    masked: (n, 6) bool, readings that a regression must not use. remarks: observations that are
    no mismatch.
    """

    events: tuple[Event, ...]
    masked: np.ndarray
    remarks: tuple[Message, ...] = ()

    @property
    def lines(self) -> tuple[float, ...]:
        """The frequencies (Hz) of the steady lines among them."""
        added = (event for event in self.events if isinstance(event, AddedSignal))
        return tuple(frequency for event in added for frequency in event.frequencies)

    def without_added(self) -> "Events":
        """The others than those that add to the readings: beside a fit these are found again."""
        kept = tuple(event for event in self.events if not isinstance(event, AddedSignal))
        return replace(self, events=kept)

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        """The mean readings (n, 6) with all events, given those predicted without any."""
        for event in self.events:
            predicted = event.applied(t, predicted)
        return predicted

    def corrected(self, t: np.ndarray, readings: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        """The readings (n, 6) without the events, NaN where they carry no information on that."""
        stages = [predicted]
        for event in self.events:
            stages.append(event.applied(t, stages[-1]))
        for event, (before, after) in reversed([*zip(self.events, pairwise(stages), strict=True)]):
            readings = event.corrected(readings, before, after)
        return readings


def channel_names(channels: tuple[int, ...]) -> Argument:
    """The channels as an argument of a message: a whole triad by its name, others one by one."""
    names: list[Message] = []
    for triad, name in zip(TRIADS, TRIAD_NAMES, strict=True):
        own = tuple(channel for channel in channels if channel in triad)
        each = [message(f"channel-{CHANNELS[channel]}") for channel in own]
        names += [name] if own == triad else each
    return tuple(names)


def significant_channels(size: np.ndarray, least: float) -> tuple[int, ...]:
    """The channels whose size (6,) over its uncertainty is significant; at least the strongest."""
    return tuple(np.flatnonzero(size > least).tolist()) or (int(size.argmax()),)


def amplitude_parameters(
    channels: tuple[int, ...], amplitudes: np.ndarray, u: np.ndarray, suffix: str = ""
) -> tuple[FoundParameter, ...]:
    """The size of complex amplitudes (6,) in some channels, named after them; u: (6,)."""
    return tuple(
        FoundParameter(
            name=CHANNELS[c] + suffix, value=float(np.abs(amplitudes[c])), unit=UNITS[c // 3],
            u=float(u[c]),
        )
        for c in channels
    )  # fmt: skip
