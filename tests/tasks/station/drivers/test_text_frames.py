import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from schemas.unit_link import TextFrame
from tasks.station.drivers.frames import find_text
from tests.tasks.station.sample_stations import sample

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
