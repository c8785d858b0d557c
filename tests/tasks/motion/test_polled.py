"""Angles that are asked for one by one: what is held is known, and what lies between is not."""

from dataclasses import replace

import numpy as np
import pytest

from schemas.recording import Recording, Stream
from tasks.motion.polled import agreeing_rate
from tasks.motion.samples import continuous
from tasks.motion.table import mean_rate
from tasks.motion.whole import whole_motion


def polled(recording: Recording, half_width_s: float, seed: int = 1) -> Recording:
    """The table read at times that are wrong by up to the half-width, unevenly and with gaps."""
    table, rng = recording.table, np.random.default_rng(seed)
    assert table is not None
    kept = np.sort(rng.choice(len(table), len(table) // 5, replace=False))
    asked = np.sort(table.t[kept] + rng.uniform(-half_width_s, half_width_s, len(kept)))
    columns = {name: values[kept] for name, values in table.columns.items()}
    stated = {"encoder": "polled", "half_width_s": half_width_s}
    manifest = recording.manifest.model_copy(update={"table_time": stated})
    return replace(recording, manifest=manifest, table=Stream(asked, columns))


def test_of_polled_angles_the_motion_is_that_of_rests_and_held_rates(plant):
    recording = polled(plant("plant_clean"), 0.02)
    motion = whole_motion(recording)
    held = np.zeros(len(motion.t), bool)
    for segment in recording.manifest.segments or ():
        rows = recording.imu.rows(segment.t_start, segment.t_end)
        if segment.kind == "static":
            assert not motion.rate[rows].any()
        elif segment.kind == "rate":
            size = np.degrees(np.linalg.norm(motion.rate[rows], axis=1))
            assert size == pytest.approx(abs(segment.rate_deg_s), rel=1e-12)
        if segment.kind in ("static", "rate"):
            held[rows] = True
    assert np.isfinite(motion.rate[held]).all()
    assert np.isnan(motion.rate[~held]).all()


def test_a_label_that_the_polled_angles_contradict_is_no_rate(plant):
    recording = polled(plant("plant_clean"), 0.02)
    segment = next(each for each in recording.manifest.segments or () if each.kind == "rate")
    assert agreeing_rate(recording, segment) is not None
    wrong = segment.model_copy(update={"rate_deg_s": 1.02 * segment.rate_deg_s})
    assert agreeing_rate(recording, wrong) is None


@pytest.mark.parametrize("step_s", [0.05, 0.9, 1.5])
def test_an_angle_that_runs_on_needs_no_unwrapping_over_a_gap(step_s):
    t = np.arange(0.0, 30.0, step_s)
    angle = np.radians(300.0 * t)
    assert continuous(Stream(t, {"a": angle}), ("a",))[:, 0] == pytest.approx(angle)


def test_an_encoder_that_starts_anew_each_turn_runs_on():
    t = np.arange(0.0, 30.0, 0.05)
    angle = np.radians(300.0 * t)
    noise = np.random.default_rng(3).normal(0.0, 1e-3, len(t))
    table = Stream(t, {"anew": angle % (2 * np.pi) + noise, "on": angle, "still": np.zeros(len(t))})
    found = continuous(table, ("anew", "on", "still"))
    assert np.diff(found[:, 0]) == pytest.approx(np.diff(angle + noise))
    assert np.array_equal(found[:, 1:], table.stack(("on", "still")))
    assert continuous(table, ("anew",), slice(0, 0)).shape == (0, 1)


def test_a_mean_rate_over_gaps_is_that_of_the_ends(plant):
    recording = plant("plant_clean")
    segment = max(
        (each for each in recording.manifest.segments or () if each.kind == "rate"),
        key=lambda each: abs(each.rate_deg_s or 0.0),
    )
    table = recording.table
    rows = np.flatnonzero((table.t >= segment.t_start) & (table.t <= segment.t_end))
    few = np.concatenate([rows[:3], rows[-3:]])
    columns = {name: values[few] for name, values in table.columns.items()}
    gapped = replace(recording, table=Stream(table.t[few], columns))
    assert mean_rate(gapped, segment) == pytest.approx(mean_rate(recording, segment), abs=1e-4)
