"""`explain` on rough recordings: what has a name can be believed, and the rest has none."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from schemas.recording import ACCEL, Recording
from storage.formats.folder import read_folder
from tasks.explain.explain import explain
from tasks.explain.explanation import UNNAMED, Explanation
from tasks.model.catalogue import catalogue
from tasks.motion.whole import whole_motion
from tasks.words import say
from tests.shared import shared_path

ROUGH = ("tumvi_room4", "encoder_roll_slow")
LONGEST = 40.0  # s: they tell as much as the five minutes, in an eighth of the time
HUM_LONGEST = 60.0  # s
HUMMING = "encoder_yaw_fast"  # to and fro, 0.9029 Hz; the unit hums on its mount at 9.595 Hz
OF_MOTION = 0.9029  # Hz


@cache
def recording(name: str) -> Recording:
    whole = read_folder(shared_path(f"data/rough/{name}"))
    longest = HUM_LONGEST if name == HUMMING else LONGEST
    table = whole.table and whole.table.at(whole.table.rows(0.0, longest))
    return replace(whole, imu=whole.imu.at(whole.imu.rows(0.0, longest)), table=table)


@cache
def explained(name: str) -> Explanation:
    return explain(recording(name))


def test_on_a_control_where_nothing_is_missing_there_is_no_mismatch():
    """Twice the noise is left, and no more than noise of the poses may make."""
    answer = explained("tumvi_room4")
    assert [each.effect for each in answer.findings if each.effect != UNNAMED] == []
    assert answer.verdict == "no_mismatch"
    assert answer.p_value > 0.005
    assert (answer.left_over > 2.0).any()


def test_on_the_tracked_control_hardly_anything_of_the_mismatch_is_explained():
    answer = explained("tumvi_room4")
    read = recording("tumvi_room4").imu.stack(ACCEL)
    before, after = (
        np.sqrt(np.nanmean((read - predicted[:, 3:]) ** 2))
        for predicted in (answer.nominal, answer.found)
    )
    assert before < 0.15
    assert after > 0.97 * before


def test_a_delay_is_known_as_far_as_its_parts_agree():
    """By fifths of the run the gyros are 11.20 to 11.34 ms late, each with u of 0.12 to 0.23 ms:
    11.28 ms on average with u of 0.08 ms.
    """
    delay = next(e for e in explained("encoder_roll_slow").findings if e.effect == "time_offset")
    (seconds,) = delay.parameters
    assert abs(seconds.value - 11.28e-3) < 2.0 * np.hypot(seconds.u, 0.08e-3)
    assert seconds.u > 0.03e-3
    assert delay.share > 0.5


@pytest.mark.parametrize("name", ROUGH)
def test_every_name_is_plausible_determined_and_gains(name):
    run = recording(name)
    terms = {term.name: term for term in catalogue(run, whole_motion(run))}
    for each in explained(name).findings:
        assert each.delta_bic > 0.0
        assert each.held_out_gain > 0.0
        if each.effect in terms:
            ranges = {p.name: p.plausible for p in terms[each.effect].parameters}
            text = [p for p in each.parameters if p.name in ranges]
            assert all(ranges[p.name][0] <= p.value <= ranges[p.name][1] for p in text)
            assert any(abs(p.value) > 2.0 * p.u for p in text)


@pytest.mark.rehearsal
def test_what_has_no_name_is_called_by_what_it_follows():
    unnamed = [
        (name, say(each.title, "en"))
        for name in (*ROUGH, "openaxes_triangle250_radius")
        for each in (*explained(name).findings, *explained(name).small)
        if each.effect == UNNAMED
    ]
    assert unnamed
    for name, title in unnamed:
        run = recording(name)
        names = [term.name for term in catalogue(run, whole_motion(run))]
        assert not [one for one in names if one in title or one.replace("_", " ") in title]


@pytest.mark.rehearsal
def test_a_rig_that_hums_and_a_late_clock_are_told_apart():
    """By hand: a line of 134 deg/s at 9.595 Hz (demodulated), beside a delay of 12.1 to 12.2 ms
    (phase of the gyro against the encoder at each odd multiple of the motion's frequency).
    """
    answer = explained(HUMMING)
    assert answer.explained_share > 0.9
    found = {
        parameter.name: parameter
        for each in reversed(answer.findings)
        for parameter in each.parameters
        if parameter.name in ("frequency", "seconds")
    }
    assert found["frequency"].value == pytest.approx(9.595, abs=0.001)
    assert abs(found["seconds"].value - 12.15e-3) < 2.0 * found["seconds"].u


@pytest.mark.rehearsal
def test_what_a_periodic_motion_leaves_is_no_line_of_its_own():
    frequencies = [
        parameter.value
        for each in explained(HUMMING).findings
        for parameter in each.parameters
        if parameter.name == "frequency"
    ]
    assert frequencies
    for frequency in frequencies:
        assert abs(frequency / OF_MOTION - round(frequency / OF_MOTION)) > 0.05
