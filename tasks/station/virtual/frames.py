"""Samples as the unit sends them: the frames of `schemas.station.FRAMES`."""

import struct
from binascii import crc_hqx

import numpy as np

from schemas.station import FRAMES

_CRC = struct.Struct("<H")


def frames(
    kind: str, numbers: np.ndarray, stamps_us: np.ndarray, counts: np.ndarray, degc: np.ndarray
) -> list[bytes]:
    """One frame for each sample: numbers (n,), unit time (n,) µs, counts (n, 6), degC (n,)."""
    frame = FRAMES[kind]
    body_of = struct.Struct(frame.format[:-1])
    counters = (numbers % 2**32).tolist()
    centi = np.rint(np.clip(degc, -300.0, 300.0) * 100.0).astype(int).tolist()
    packed = []
    for row in zip(counters, stamps_us.tolist(), counts.tolist(), centi, strict=True):
        counter, stamp, values, temperature = row
        body = body_of.pack(frame.sync, counter, stamp, *values, temperature)
        packed.append(body + _CRC.pack(crc_hqx(body, 0)))
    return packed
