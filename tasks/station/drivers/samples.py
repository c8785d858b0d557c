"""The unit's samples decoded from its frames, of either kind."""

from dataclasses import dataclass

import numpy as np

from schemas.recording import Stream
from schemas.unit_link import SIZES, AnyFrame, FrameField, TextFrame

COUNTER_TURN = 2**32
NO_COUNTER = -1
LAST_STAMP_US = 2.0**62


def sample_type(frame: AnyFrame) -> np.dtype:
    """A numpy record: counter, stamp (µs since power-on) and the channels' values in SI."""
    return np.dtype(
        [("counter", "<i8"), ("stamp", "<i8"), ("values", "<f8", (len(frame.channels),))]
    )


def no_samples(frame: AnyFrame) -> np.ndarray:
    """None at all, (0,)."""
    return np.empty(0, sample_type(frame))


@dataclass(frozen=True)
class FrameSearch:
    """What was found in some bytes: samples (n,), how many frames were bad, and bytes left over."""

    samples: np.ndarray
    bad: int
    rest: bytes


def to_stream(samples: np.ndarray, frame: AnyFrame, shift_us: int = 0) -> Stream:
    """Samples over their own time stamps, moved by `shift_us`."""
    columns = dict(zip(frame.channels, samples["values"].T, strict=True))
    return Stream((samples["stamp"] + shift_us) / 1e6, columns)


def counter_turn(frame: AnyFrame) -> int:
    """The number of frames after which the counter wraps; that of 32 bits if unknown."""
    bits = _bits(frame, "counter")
    return COUNTER_TURN if bits is None else min(2**bits, COUNTER_TURN)


def stamp_turn_us(frame: AnyFrame) -> int | None:
    """The time after which the time stamp wraps, µs; None if it does not within a lifetime."""
    bits = _bits(frame, "time")
    if bits is None or bits > 32:
        return None
    factor = next(field.factor for field in frame.fields if field.name == "time")
    return round(2**bits * factor * 1e6)


def _bits(frame: AnyFrame, name: str) -> int | None:
    if isinstance(frame, TextFrame):
        return None
    field = next((field for field in frame.fields if field.name == name), None)
    if field is None or field.type.startswith("float"):
        return None
    return 8 * SIZES[field.type] - field.type.startswith("int")


def filled(frame: AnyFrame, raw: dict[str, np.ndarray], n: int) -> np.ndarray:
    """Samples (n,) from the raw values of each field, (n,) each; stamps are -1 if there are
    none.
    """
    samples = np.empty(n, sample_type(frame))
    fields: dict[str, FrameField] = {field.name: field for field in frame.fields}
    samples["counter"] = raw.get("counter", NO_COUNTER)
    samples["stamp"] = -1
    if "time" in raw:
        stamps = np.rint(raw["time"] * (fields["time"].factor * 1e6))
        is_time = np.abs(stamps) < LAST_STAMP_US  # nan is none
        samples["stamp"] = np.where(is_time, stamps, 0)
    for place, name in enumerate(frame.channels):
        samples["values"][:, place] = raw[name] * fields[name].factor
    return samples[is_time] if "time" in raw else samples
