"""What an event is: recognised, described, with what it makes of predicted readings."""

from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import FoundParameter
from tasks.explain.channels import TRIADS
from tasks.model.term import Text

UNITS = ("rad/s", "m/s2")
TRIAD_NAMES: tuple[Text, Text] = (("gyros", "陀螺"), ("accelerometers", "加速度计"))
CHANNEL_NAMES: tuple[Text, ...] = tuple(
    (f"{en} {axis}", f"{zh} {axis}")
    for en, zh in (("gyro", "陀螺"), ("accelerometer", "加速度计"))
    for axis in "xyz"
)


@dataclass(frozen=True)
class Event:
    """Something that happened to the readings, which no regressor describes.

    effect: its catalogue name, or `unnamed`. channels: 0 to 5 that it is seen in.
    p_value: corrected for how many were looked for. rows: (n,) bool, where; None: everywhere.
    """

    effect: str
    channels: tuple[int, ...]
    parameters: tuple[FoundParameter, ...]
    p_value: float
    description: Text
    rows: np.ndarray | None

    def applied(self, t: np.ndarray, predicted: np.ndarray, noise: np.ndarray) -> np.ndarray:
        """The mean reading (n, 6) with the event, given the predicted one (n, 6) without it.

        t: (n,) s. noise: standard deviation of a sample, (6,) or (n, 6).
        """
        return predicted

    def freed(
        self, readings: np.ndarray, before: np.ndarray, after: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """The readings (n, 6) as they were before the event, and which (n, 6) tell nothing then.

        before, after: what was predicted without it and with it.
        """
        return readings - (after - before), None


@dataclass(frozen=True)
class Events:
    """All events of a recording, in the order in which they act on a reading.

    masked: (n, 6) bool, what a regression must not use. remarks: what is no mismatch but is told.
    """

    events: tuple[Event, ...]
    masked: np.ndarray
    remarks: tuple[Text, ...] = ()

    def applied(self, t: np.ndarray, predicted: np.ndarray, noise: np.ndarray) -> np.ndarray:
        """The mean reading (n, 6) with all events, given the predicted one without them."""
        for event in self.events:
            predicted = event.applied(t, predicted, noise)
        return predicted

    def undone(
        self, t: np.ndarray, readings: np.ndarray, predicted: np.ndarray, noise: np.ndarray
    ) -> np.ndarray:
        """The readings (n, 6) as they were without the events, NaN where that cannot be told."""
        course = [predicted]
        for event in self.events:
            course.append(event.applied(t, course[-1], noise))
        for event, before, after in reversed(
            list(zip(self.events, course[:-1], course[1:], strict=True))
        ):
            readings, untold = event.freed(readings, before, after)
            if untold is not None:
                readings = np.where(untold, np.nan, readings)
        return readings


def named(channels: tuple[int, ...]) -> Text:
    """The channels in words."""
    for triad, names in zip(TRIADS, TRIAD_NAMES, strict=True):
        if channels == triad:
            return names
    english = ", ".join(CHANNEL_NAMES[channel][0] for channel in channels)
    return english, "、".join(CHANNEL_NAMES[channel][1] for channel in channels)
