import struct
import zlib
from binascii import crc_hqx

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from schemas.unit_link import TextFrame, UnitLink
from tasks.station.drivers.unit import (
    StampSequence,
    check_sums,
    find_binary,
    find_text,
    no_samples,
    sample_type,
    to_stream,
)
from tests.tasks.station.sample_stations import angles_link, rates_link, sample

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


VNIMU = TextFrame.model_validate(sample("text_table")["unit_link"]["frame"])
CSV = TextFrame.model_validate(sample("modbus_polled")["unit_link"]["frame"])
NAMES = ["accel_x", "accel_y", "accel_z", "gyro_x", "gyro_y", "gyro_z", "temperature"]


def line(*values: float) -> bytes:
    body = "VNIMU," + ",".join(f"{value:+.4f}" for value in values)
    check = 0
    for octet in body.encode():
        check ^= octet
    return f"${body}*{check:02X}\r\n".encode()


GOOD = line(1, 2, 3, 0.1, -0.2, -9.8, 0.001, 0.002, 0.003, 21.5, 101.3)


def test_a_line_gives_its_channels_in_si():
    found = find_text(GOOD, VNIMU)
    assert list(VNIMU.channels) == NAMES
    values = found.samples["values"][0]
    assert values.tolist() == [0.1, -0.2, -9.8, 0.001, 0.002, 0.003, 21.5]
    assert (found.bad, found.rest) == (0, b"")


def test_engineering_units_become_si_and_a_first_line_without_check_sum_is_not_trusted():
    lines = b"7;70;1;2;3;0;0;1\r\n" * 2
    found = find_text(lines, CSV)
    assert found.samples["counter"].tolist() == [7]
    assert found.samples["stamp"].tolist() == [70_000]
    expected = [*np.radians([1, 2, 3]), 0.0, 0.0, 9.80665]
    assert found.samples["values"][0] == pytest.approx(expected)
    again = find_text(found.rest + b"8;80;1;2;3;0;0;1\r\n", CSV)
    assert again.samples["counter"].tolist() == [8]


@given(st.lists(st.integers(1, 90), max_size=8), st.binary(max_size=40))
def test_lines_are_found_however_the_bytes_come_and_whatever_comes_before(pieces, noise):
    data = noise.replace(b"\n", b"") + GOOD * 3
    rest, found, start = b"", 0, 0
    for size in [*pieces, len(data)]:
        search = find_text(rest + data[start : start + size], VNIMU)
        start, rest = start + size, search.rest
        found += len(search.samples)
    assert found == 3


@given(st.integers(1, len(GOOD) - 3), st.integers(1, 255))
def test_a_changed_byte_never_passes(place, change):
    broken = bytearray(GOOD)
    broken[place] ^= change
    values = find_text(bytes(broken), VNIMU).samples["values"]
    case = 0x20  # a hexadecimal digit in the other case is the same digit
    assert len(values) == 0 or (change == case and place > GOOD.index(b"*"))


@given(st.binary(max_size=300))
def test_garbage_is_no_line_and_never_an_error(data):
    assert len(find_text(data, VNIMU).samples) == 0
    assert len(find_text(data, CSV).rest) <= 4096 + 2


LINK = rates_link()
NARROW = LINK.model_dump(mode="json")
NARROW["frame"]["fields"][1] = {"name": "time", "type": "uint32", "unit": "us"}
UNTIMED = UnitLink.model_validate(sample("text_table")["unit_link"])


def samples(*stamps_us: int, link: UnitLink = LINK) -> np.ndarray:
    made = np.zeros(len(stamps_us), sample_type(link.frame))
    made["stamp"] = stamps_us
    return made


def fed_stamps(sequence: StampSequence, *stamps_us: int) -> list[int]:
    return sequence.take(samples(*stamps_us), 0.0)["stamp"].tolist()


def test_a_false_frame_among_good_ones_is_dropped_and_counted():
    sequence = StampSequence(LINK)
    assert fed_stamps(sequence, 0, 10_000, 7_000_000_000, 20_000, 3, 30_000) == [
        0, 10_000, 20_000, 30_000,
    ]  # fmt: skip
    assert sequence.rejected == 2


def test_a_last_frame_out_of_order_waits_for_the_next_to_tell():
    sequence = StampSequence(LINK)
    assert fed_stamps(sequence, 0, 10_000, 999_000_000) == [0, 10_000]
    assert fed_stamps(sequence, 20_000, 30_000) == [20_000, 30_000]
    assert sequence.rejected == 1


def test_a_silence_and_a_restart_are_told_by_two_frames():
    sequence = StampSequence(LINK)
    fed_stamps(sequence, 0, 10_000)
    assert fed_stamps(sequence, 60_000_000) == []
    assert fed_stamps(sequence, 60_010_000) == [60_000_000, 60_010_000]
    assert fed_stamps(sequence, 0, 10_000) == [0, 10_000]
    assert sequence.rejected == 0


def test_stamps_of_32_bits_run_on_past_their_turnover():
    sequence = StampSequence(UnitLink.model_validate(NARROW))
    end = 2**32
    assert fed_stamps(sequence, end - 20_000, end - 10_000, 0) == [end - 20_000, end - 10_000, end]
    assert fed_stamps(sequence, 10_000) == [end + 10_000]


def test_samples_without_time_or_counter_are_stamped_as_they_arrive():
    sequence = StampSequence(UNTIMED)
    first = sequence.take(samples(*[-1] * 3, link=UNTIMED), 100.0)["stamp"]
    assert first.tolist() == [99_980_000, 99_990_000, 100_000_000]
    early = sequence.take(samples(*[-1] * 2, link=UNTIMED), 100.005)["stamp"]
    assert early.min() > 100_000_000
    assert len(sequence.take(no_samples(UNTIMED.frame), 0.0)) == 0
