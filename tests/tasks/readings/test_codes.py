"""Codes that firmware joined wrongly are put right; right ones are left alone, whatever happens."""

from dataclasses import replace
from functools import partial

import firmware
import numpy as np
import pytest
from eventful import eventful
from firmware import FULL, UNITS, Made, Unit, made

from schemas.recording import ACCEL, GYRO
from storage.formats.folder import read_folder
from tasks.readings.codes import bug_in_words, codes_put_right
from tasks.readings.stamps import with_instants
from tasks.words import texts
from tests.shared import shared_path

CHANNELS = GYRO + ACCEL
EVERY = tuple(range(6))
KNOWN = ("table", "labels", "neither")
EACH = [  # of the units a quarter in `make test`: words of two and three bytes, every way to know
    pytest.param(number, marks=() if number in (0, 7, 8) else pytest.mark.rehearsal)
    for number in range(len(UNITS))
]


def known(number: int) -> str:
    return KNOWN[number % 3]


def off(one: Made) -> tuple[np.ndarray, set[str], np.ndarray]:
    """Share (6,) of the readings in segments that stay wrong, the bugs that were named, and the
    share (6,) of those that are said to be undecided.
    """
    right = codes_put_right(one.recording)
    wrong = np.abs(right.imu.stack(CHANNELS) - one.right) > 0.6 * one.step
    undecided = np.zeros(6)
    for each in right.wrong_codes:
        undecided[CHANNELS.index(each.channel)] = each.undecided[one.held].mean()
    return wrong[one.held].mean(axis=0), {each.bug for each in right.wrong_codes}, undecided


@pytest.mark.parametrize("number", EACH)
def test_right_codes_are_left_alone(number):
    one = made(UNITS[number], number, None, known=known(number))
    assert codes_put_right(one.recording) is one.recording


WRONG = {  # what of a unit's words goes wrong, which bug that is called, and of which units
    "signed low byte": (firmware.low_byte_signed, "signed-low", UNITS),
    "bytes exchanged": (firmware.bytes_exchanged, "bytes", UNITS),
    "read as unsigned": (firmware.read_as_unsigned, "unsigned", UNITS),
    "wrapped": (firmware.wrapped, "wrap", FULL),
}


@pytest.mark.parametrize("number", EACH)
@pytest.mark.parametrize("fault", WRONG)
def test_what_no_bit_is_lost_of_is_put_right_exactly(fault, number):
    made_wrong, bug, units = WRONG[fault]
    unit = units[number % len(units)]
    one = made(unit, number, partial(made_wrong, bits=unit.bits), EVERY, known(number))
    wrong, bugs, undecided = off(one)
    assert wrong.max() == 0.0
    assert bugs - ({"wrap"} if bug == "bytes" else set()) == {bug}
    assert bug == "bytes" or not undecided.any()


@pytest.mark.parametrize("number", [0, 4])
def test_one_channel_of_six_is_put_right(number):
    one = made(UNITS[number], number, firmware.low_byte_signed, (number % 6,), known(number))
    wrong, bugs, _ = off(one)
    assert (wrong.max(), bugs) == (0.0, {"signed-low"})


@pytest.mark.parametrize("number", EACH)
@pytest.mark.parametrize("tells", ["table", "labels"])
def test_what_or_wiped_out_is_put_right_or_said_to_be_undecided(number, tells):
    unit = UNITS[number]
    fault = partial(firmware.low_byte_or, bits=unit.bits)
    wrong, bugs, undecided = off(made(unit, number, fault, EVERY, tells))
    assert bugs == {"signed-low-or"}
    assert (wrong <= undecided + 1e-3).all()
    if number in (0, 4, 5, 10):  # noise well below a byte, and more than a page of readings
        assert wrong.max() < 1e-3


@pytest.mark.parametrize("bit", [5, 6, 7])
@pytest.mark.parametrize("level", [0, 1])
def test_a_stuck_bit_is_told_and_the_means_are_put_nearer(bit, level):
    noisy = Unit(counts=(131.0, 8192.0), noise=(0.15, 0.004))
    channel = (bit + level) % 6
    one = made(noisy, bit, partial(firmware.stuck, bit=bit, level=level), (channel,), "labels")
    right = codes_put_right(one.recording)
    (found,) = right.wrong_codes
    assert (found.bug, found.codes) == ("stuck-high" if level else "stuck-low", 1 << bit)
    before, after = (
        abs(np.mean((each.imu.stack(CHANNELS) - one.right)[one.held, channel]))
        for each in (one.recording, right)
    )
    assert after < 0.6 * before


def test_bits_lost_above_are_put_back_by_following_the_numbers():
    unit = FULL[1]
    wrong, bugs, _ = off(made(unit, 1, partial(firmware.wrapped, bits=13), EVERY, "neither"))
    assert wrong.max() == 0.0
    assert bugs == {"wrap"}


@pytest.mark.parametrize(
    ("rate", "quick", "top", "limit", "tells", "decimals"),
    [
        (100.0, 100.0, 300.0, 250.0, "table", None), (25.0, 50.0, 300.0, 220.5, "neither", None),
        (10.0, 40.0, 140.0, 125.0, "labels", 4), (100.0, 200.0, 600.0, 500.0, "labels", 3),
    ],
)  # fmt: skip
def test_readings_on_no_lattice_wrap_at_any_full_scale(rate, quick, top, limit, tells, decimals):
    unit = Unit(rate=rate, quick=quick, top=top, counts=(20.0, 8192.0))
    one = made(unit, 3, None, known=tells)
    full, columns = np.radians(limit), dict(one.recording.imu.columns)
    for c, name in enumerate(GYRO):
        fine = one.right[:, c] + 1e-4 * np.random.default_rng(c).standard_normal(len(one.right))
        read = np.mod(fine + full, 2.0 * full) - full
        columns[name] = read if decimals is None else np.round(read, decimals)
    imu = replace(one.recording.imu, columns=columns)
    right = codes_put_right(replace(one.recording, imu=imu))
    assert [(each.channel, each.bug) for each in right.wrong_codes] == [(c, "wrap") for c in GYRO]
    off = np.abs(right.imu.stack(GYRO) - one.right[:, :3])
    assert off[one.held].max() < 2e-3 * full


def test_a_tap_that_jumps_by_the_whole_range_is_no_wrap_and_may_be_told():
    one = made(FULL[1], 4, None, known="neither")
    columns = dict(one.recording.imu.columns)
    for row, size in ((700, (121.0, -155.0, -18.0, 92.0)), (2300, (140.0, -139.0, 97.0))):
        columns["accel_z"][row : row + len(size)] = size
    tapped = replace(one.recording, imu=replace(one.recording.imu, columns=columns))
    right = codes_put_right(tapped)
    assert not right.wrong_codes
    assert right.imu is tapped.imu


def test_what_a_stuck_bit_leaves_is_whole_or_undecided():
    unit = Unit(noise=(0.05, 0.001))
    one = made(unit, 5, partial(firmware.stuck, bit=5, level=1), (2,), "table")
    right = codes_put_right(one.recording)
    (found,) = right.wrong_codes
    number = right.imu.columns["gyro_z"][one.held] / one.step[2]
    decided = np.abs(number - np.rint(number)) < 1e-6
    assert decided.mean() > 0.85
    off = np.abs(number - one.right[one.held, 2] / one.step[2])[decided]
    assert np.mean(off > 0.5) < 2e-3
    assert found.undecided[one.held].mean() < 0.05


def test_a_bias_that_jumps_to_and_fro_by_a_byte_is_no_fault_of_the_codes():
    one = made(Unit(), 3, None)
    columns = dict(one.recording.imu.columns)
    flips = np.cumsum(np.random.default_rng(5).random(len(one.recording.imu)) < 0.1) % 2
    columns["gyro_z"] = columns["gyro_z"] + 256 * one.step[2] * flips
    imu = type(one.recording.imu)(one.recording.imu.t, columns)
    jumping = type(one.recording)(one.recording.manifest, imu, one.recording.table)
    assert codes_put_right(jumping) is jumping


@pytest.mark.parametrize(
    ("name", "bug"),
    [
        ("low_byte_signed", "signed-low"), ("low_byte_signed_25hz", "signed-low"),
        ("low_byte_signed_no_table", "signed-low"), ("low_byte_signed_or", "signed-low-or"),
    ],
)  # fmt: skip
def test_cases_from_the_field_are_put_right_in_all_six_channels(name, bug):
    right = codes_put_right(read_folder(shared_path(f"data/field/{name}")))
    assert [(one.channel, one.bug) for one in right.wrong_codes] == [(c, bug) for c in CHANNELS]
    assert {one.codes for one in right.wrong_codes} == {256.0}
    assert max(one.undecided.mean() for one in right.wrong_codes) < 1e-4
    assert all(texts(bug_in_words(one)) for one in right.wrong_codes)
    assert codes_put_right(right) is right


# Where a lot happens and no logger erred, not one reading and not one stamp is moved.

FEW, MANY = range(60), range(60, 1500)


def moved(seed: int) -> str:
    """What was moved in a recording; empty if nothing was."""
    recording, happens = eventful(seed)
    right = codes_put_right(with_instants(recording))
    wrong = [f"{one.channel} {one.bug} {one.share:.2g}" for one in right.wrong_codes]
    wrong += [] if np.array_equal(right.imu.t, recording.imu.t) else ["stamps"]
    same = all(
        np.array_equal(right.imu.columns[name], column, equal_nan=True)
        for name, column in recording.imu.columns.items()
    )
    return "" if same and not wrong else f"{seed}: {wrong} {happens}"


def test_nothing_is_moved_where_no_logger_erred():
    assert [each for each in map(moved, FEW) if each] == []


@pytest.mark.rehearsal
def test_nothing_is_moved_in_many_more():
    assert [each for each in map(moved, MANY) if each] == []
