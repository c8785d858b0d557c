import struct
import zlib
from binascii import crc_hqx

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tasks.station.drivers.frames import check_sums, find_binary
from tasks.station.drivers.samples import to_stream
from tests.tasks.station.sample_stations import angles_link, rates_link

RATES, ANGLES = rates_link().frame, angles_link().frame
FRAME_BYTES = 42


def frame(counter: int, stamp_us: int = 0, counts: tuple[int, ...] = (1, 2, 3, 4, 5, 6)) -> bytes:
    return packed("<HIQ3i3ih", 0x55AA, counter, stamp_us, counts)


def packed(layout: str, sync: int, counter: int, stamp_us: int, counts: tuple[int, ...]) -> bytes:
    body = struct.pack(layout, sync, counter, stamp_us, *counts, 2512)
    return body + struct.pack("<H", crc_hqx(body, 0))


def fed(data: bytes, pieces: list[int]) -> tuple[list[int], int]:
    """Counters found, and bad frames, when the data come in pieces of these sizes."""
    rest, counters, bad, start = b"", [], 0, 0
    for size in [*pieces, len(data)]:
        found = find_binary(rest + data[start : start + size], RATES)
        start += size
        rest = found.rest
        bad += found.bad
        counters += found.samples["counter"].tolist()
    return counters, bad


# bytes that like to look like the beginning of a frame
GARBAGE = st.lists(
    st.one_of(st.binary(max_size=60), st.just(b"\xaa\x55"), st.just(frame(77)[:30])), max_size=3
).map(b"".join)


@given(st.lists(st.binary(min_size=5, max_size=5), min_size=1, max_size=8))
def test_check_sums_are_those_of_the_libraries(rows):
    octets = np.frombuffer(b"".join(rows), np.uint8).reshape(len(rows), 5)
    assert check_sums("crc16_xmodem", octets).tolist() == [crc_hqx(row, 0) for row in rows]
    ccitt = [crc_hqx(row, 0xFFFF) for row in rows]
    assert check_sums("crc16_ccitt_false", octets).tolist() == ccitt
    assert check_sums("crc32", octets).tolist() == [zlib.crc32(row) for row in rows]
    assert check_sums("sum8", octets).tolist() == [sum(row) % 256 for row in rows]


@pytest.mark.parametrize(("kind", "sum_of_digits"), [("crc16_modbus", 0x4B37), ("xor8", 0x31)])
def test_check_sums_of_the_digits_are_the_published_ones(kind, sum_of_digits):
    digits = np.frombuffer(b"123456789", np.uint8)[None]
    assert check_sums(kind, digits).tolist() == [sum_of_digits]


@given(
    st.lists(GARBAGE, min_size=2, max_size=8),
    st.lists(st.integers(1, 100), max_size=12),
)
def test_garbage_between_frames_costs_no_whole_frame(garbage, pieces):
    data = b"".join(piece + frame(number) for number, piece in enumerate(garbage))
    counters, _ = fed(data + b"\0" * FRAME_BYTES, pieces)
    assert counters == list(range(len(garbage)))


@given(st.integers(0, FRAME_BYTES - 1), st.integers(1, 255))
def test_a_changed_byte_loses_its_frame_and_no_other(place, change):
    broken = bytearray(frame(1))
    broken[place] ^= change
    counters, bad = fed(frame(0) + bytes(broken) + frame(2) + frame(3), [])
    assert counters == [0, 2, 3]
    assert bad == (0 if place < 2 else 1)


@given(st.lists(st.integers(1, 60), max_size=12))
def test_bad_frames_are_counted_alike_however_the_bytes_come(pieces):
    broken = bytearray(frame(1))
    broken[20] ^= 1
    noisy = (frame(0) + bytes(broken) + b"\xaa\x55\0") * 4 + frame(0)
    assert fed(noisy, pieces)[1] == 4


def test_sync_word_inside_a_good_frame_is_not_a_bad_frame():
    inside = frame(0x55AA55AA, counts=(0x55AA, 2, 3, 4, 5, 6))
    assert fed(inside * 3, [20, 30]) == ([0x55AA55AA] * 3, 0)


def test_counts_become_si_over_the_units_own_stamps():
    counts = (1000, -2000, 3000, 980665, -(2**31), 2**31 - 1)
    found = find_binary(frame(7, 1_500_000, counts), RATES)
    stream = to_stream(found.samples, RATES, shift_us=-250_000)
    assert stream.t.tolist() == [1.25]
    assert stream.columns["gyro_y"][0] == -2000 * 1e-6
    assert stream.columns["accel_x"][0] == 980665 * 1e-5
    assert stream.columns["accel_z"][0] == (2**31 - 1) * 1e-5
    assert stream.columns["temperature"][0] == 25.12


def test_angles_become_radians_however_far_they_have_run_on():
    counts = (2**40, -(2**40), 3, 980665, -2, 3)
    sent = packed("<HIQ3q3ih", 0x55AB, 7, 1_500_000, counts)
    stream = to_stream(find_binary(sent, ANGLES).samples, ANGLES)
    assert list(stream.columns) == [
        *("angle_x", "angle_y", "angle_z"), *("accel_x", "accel_y", "accel_z"), "temperature"
    ]  # fmt: skip
    assert stream.columns["angle_x"][0] == 2**40 * 1e-7
    assert stream.columns["angle_y"][0] == -(2**40) * 1e-7
    assert stream.columns["accel_x"][0] == 980665 * 1e-5


def test_frames_of_one_kind_are_none_of_the_other():
    sent = packed("<HIQ3q3ih", 0x55AB, 7, 1, (1, 2, 3, 4, 5, 6)) * 5
    assert len(find_binary(sent, ANGLES).samples) == 5
    assert len(find_binary(sent, RATES).samples) == 0
