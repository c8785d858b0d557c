"""Some thousand inputs for each parser; the command has a million."""

import struct
from binascii import crc_hqx
from dataclasses import replace

import pytest

from schemas.unit_link import BinaryFrame
from tests.proof.fuzz import ANSWERS, KINDS, feed

COUNT = 2000


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_no_frame_is_taken_whose_damage_the_check_sum_shows(kind):
    tally = feed(kind, COUNT, seed=2)
    assert tally.wrong_though_shown == 0
    assert tally.lost == 0


@pytest.mark.parametrize("feed_answers", ANSWERS.values(), ids=ANSWERS)
def test_answers_are_read_rightly_or_refused(feed_answers):
    assert feed_answers(COUNT, 3).wrong_though_shown == 0


def test_damaged_frames_that_are_taken_are_found_out():
    """A check sum of the last readings alone shows no damage of those before."""
    own, first = KINDS[0], 30
    frame = BinaryFrame.model_validate(own.frame.model_dump() | {"check_from": first})

    def made(reading):
        body = own.made(reading)[:-2]
        return body + struct.pack("<H", crc_hqx(body[first:], 0))

    assert feed(replace(own, frame=frame, made=made), 800, seed=3).wrong_though_shown > 0
