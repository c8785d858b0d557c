"""Checksums of frames, for many rows of bytes at once."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from schemas.unit_link import Check


@dataclass(frozen=True)
class Crc:
    """A cyclic redundancy check, as catalogues of them give it."""

    width: int
    polynomial: int
    start: int
    is_reflected: bool
    end_xor: int


CRCS = {
    "crc16_xmodem": Crc(16, 0x1021, 0, False, 0),
    "crc16_ccitt_false": Crc(16, 0x1021, 0xFFFF, False, 0),
    "crc16_modbus": Crc(16, 0x8005, 0xFFFF, True, 0),
    "crc32": Crc(32, 0x04C11DB7, 0xFFFFFFFF, True, 0xFFFFFFFF),
}


def check_sums(kind: Check, rows: np.ndarray) -> np.ndarray:
    """The check sum of each row of octets, (n, k) -> (n,) uint64."""
    if kind == "sum8":
        return rows.astype(np.uint64).sum(axis=1) & np.uint64(0xFF)
    if kind == "xor8":
        return np.bitwise_xor.reduce(rows, axis=1).astype(np.uint64)
    return _crc(CRCS[kind], rows)


def _crc(crc: Crc, rows: np.ndarray) -> np.ndarray:
    table = _table(crc)
    register = np.full(len(rows), crc.start, np.uint64)
    mask, octet = np.uint64(2**crc.width - 1), np.uint64(0xFF)
    high, eight = np.uint64(crc.width - 8), np.uint64(8)
    for column in rows.T:
        if crc.is_reflected:
            register = (register >> eight) ^ table[(register ^ column) & octet]
        else:
            register = ((register << eight) & mask) ^ table[(register >> high) ^ column]
    return register ^ np.uint64(crc.end_xor)


@lru_cache
def _table(crc: Crc) -> np.ndarray:
    """What each octet adds, (256,) uint64."""
    top, mask = 1 << (crc.width - 1), 2**crc.width - 1
    polynomial = crc.polynomial
    if crc.is_reflected:
        polynomial = int(f"{polynomial:0{crc.width}b}"[::-1], 2)
    table = []
    for octet in range(256):
        register = octet if crc.is_reflected else octet << (crc.width - 8)
        for _ in range(8):
            if crc.is_reflected:
                register = (register >> 1) ^ (polynomial if register & 1 else 0)
            else:
                register = ((register << 1) ^ (polynomial if register & top else 0)) & mask
        table.append(register)
    return np.array(table, np.uint64)
