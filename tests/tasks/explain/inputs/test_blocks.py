"""Readings and motion as means over blocks: nothing is lost, nothing counts twice."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.recording import Recording, Stream, TableAxis
from tasks.explain.explanation import CHANNELS
from tasks.explain.inputs.blocks import Blocks, block_means, full_rate
from tasks.model.model import Model
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.reference_noise import EXACT
from tests.manifests import manifest_of
from tests.moved_by_hand import poses, recording

GRAVITY, RATE, REST, RESTS = 9.8, 100.0, 10.0, 6  # m/s², Hz, s
SIGMA = np.repeat([1e-4, 2e-3], 3)


def rested(
    change: Callable[[np.ndarray], np.ndarray] = lambda readings: readings,
    drop: np.ndarray | None = None,
    seconds: float = RESTS * REST,
) -> Recording:
    """Six labelled rests of 10 s with z up.

    change: of the readings (n, 6). drop: rows that were not recorded.
    """
    t = np.arange(round(seconds * RATE)) / RATE
    segments = [
        {
            "name": f"rest{k}", "kind": "static", "up": "+z",
            "t_start": k * REST, "t_end": (k + 1) * REST,
        }
        for k in range(RESTS)
    ]  # fmt: skip
    noise = np.random.default_rng(7).standard_normal((len(t), 6)) * SIGMA
    readings = change(noise + np.array([0.0, 0.0, 0.0, 0.0, 0.0, GRAVITY]))
    kept = np.ones(len(t), bool)
    if drop is not None:
        kept[drop] = False
    manifest = manifest_of("rests", {"gravity_m_s2": GRAVITY}, segments=segments)
    columns = {name: readings[kept, c].copy() for c, name in enumerate(CHANNELS)}
    return Recording(manifest, Stream(t[kept], columns))


def samples(blocks: Blocks, step: int) -> np.ndarray:
    """(n, 6) how many samples of full weight stand in each block."""
    return blocks.weight**2 * step


@pytest.mark.parametrize("rate", [25.0, 20.0, 50.0, 100.0, 400.0])
def test_every_sample_is_kept_once(rate):
    full = full_rate(rested())
    blocks = block_means(full, rate)
    step = max(1, round(RATE / rate))
    assert blocks.rate == pytest.approx(RATE / step)
    assert samples(blocks, step).sum() == pytest.approx(full.readings.size)
    total = (samples(blocks, step) * blocks.readings).sum(axis=0)
    np.testing.assert_allclose(total, full.readings.sum(axis=0), rtol=1e-9, atol=1e-9)
    assert np.diff(blocks.t) == pytest.approx(step / RATE)


def test_samples_that_are_masked_or_not_a_number_do_not_count():
    def spoilt(readings: np.ndarray) -> np.ndarray:
        readings[333:351, 1] = np.nan
        return readings

    full = full_rate(rested(spoilt))
    masked = np.zeros(full.readings.shape, bool)
    masked[2000:2010, 4] = True
    used = np.isfinite(full.readings) & ~masked
    blocks = block_means(full, 25.0, masked)
    np.testing.assert_allclose(samples(blocks, 4).sum(axis=0), used.sum(axis=0), rtol=1e-9)
    total = (samples(blocks, 4) * blocks.readings).sum(axis=0)
    direct = np.where(used, full.readings, 0.0).sum(axis=0)
    np.testing.assert_allclose(total, direct, rtol=1e-9, atol=1e-9)
    assert (blocks.readings[blocks.weight == 0] == 0).all()


def test_rows_that_were_not_recorded_leave_empty_blocks():
    full = full_rate(rested(drop=np.r_[1000:1023]))
    blocks = block_means(full, 25.0)
    assert (blocks.weight[:, 0] == 0).sum() == 5  # whole blocks of 23 missing samples
    np.testing.assert_allclose(samples(blocks, 4)[:, :3].sum(axis=0), 5977.0, rtol=1e-9)
    assert not blocks.motion.known[250:255].any()
    assert blocks.motion.known.sum() == len(blocks.t) - 5


def test_a_block_at_the_corner_of_a_motion_weighs_little():
    """The table begins to turn between two samples; nobody knows when exactly."""
    full = full_rate(rested())
    t, began = full.motion.t, 31.234
    rate = np.zeros_like(full.motion.rate)
    rate[:, 2] = np.where(t > began, 1.0 * (t - began), 0.0).clip(max=2.0)
    turning = replace(full, motion=replace(full.motion, rate=rate))
    blocks = block_means(turning, 25.0)
    for corner in (began, began + 2.0):
        near = np.abs(blocks.t - corner) < 0.03
        assert blocks.weight[near, :3].max() < 0.5
        assert blocks.weight[np.abs(blocks.t - corner) < 0.02, :3].min() < 0.1
    ramp = (blocks.t > began + 0.2) & (blocks.t < began + 1.8)
    assert blocks.weight[ramp, :3].min() > 0.9
    away = (np.abs(blocks.t - began) > 0.3) & (np.abs(blocks.t - began - 2.0) > 0.3)
    assert blocks.weight[away, :3].min() > 0.9


def test_a_shaken_segment_weighs_less_and_says_so():
    """Three times the noise while it turns is vibration: nine times the variance."""

    def shaken(readings: np.ndarray) -> np.ndarray:
        rows = slice(2000, 3000)
        readings[rows] += np.random.default_rng(8).standard_normal((1000, 6)) * SIGMA * np.sqrt(8.0)
        return readings

    blocks = block_means(full_rate(rested(shaken)), 25.0)
    rows = (blocks.t > 20.2) & (blocks.t < 29.8)
    assert np.median(blocks.weight[rows]) == pytest.approx(1.0 / 3.0, rel=0.1)
    rest_variance = (blocks.t > 31.0) & (blocks.t < 59.0)
    np.testing.assert_allclose(blocks.weight[rest_variance], 1.0, rtol=1e-6)


def test_rounding_has_a_floor_that_averages_out_only_where_noise_stirs_it():
    coarse, fine = 0.01, 1e-3  # m/s²: the noise is 2e-3

    def rounded(step: float) -> np.ndarray:
        full = full_rate(rested(lambda readings: np.round(readings / step) * step))
        return block_means(full, 25.0).floor[3:]

    np.testing.assert_allclose(rounded(fine), fine**2 / 12.0 / 4.0, rtol=1e-6)
    np.testing.assert_allclose(rounded(coarse), coarse**2 / 12.0, rtol=1e-6)
    plain = block_means(full_rate(rested()), 25.0).floor[3:]
    assert (plain < (0.1 * SIGMA[3:]) ** 2).all()


def test_a_recording_that_tells_no_motion_is_refused():
    recording = rested()
    silent = recording.manifest.model_copy(update={"segments": None})
    with pytest.raises(Unusable, match="does not show how the unit moved"):
        full_rate(replace(recording, manifest=silent))


def on_a_shaft(step: float) -> Recording:
    """At rest, then two slow swings about z, then at rest; by an encoder of some step, rad."""
    t = np.arange(6000) / RATE
    moving = (t > 20.0) & (t < 40.0)
    angle = np.where(moving, 0.8 * np.sin(0.3 * np.pi * (t - 20.0)) ** 3, 0.0)
    read = np.round(angle / step) * step if step else angle
    readings = np.random.default_rng(3).standard_normal((len(t), 6)) * SIGMA
    readings[:, 2] += np.gradient(angle, t)
    readings[:, 5] += GRAVITY
    manifest = manifest_of("shaft", {"gravity_m_s2": GRAVITY}, {"shaft": (0, 0, 1)})
    columns = {name: readings[:, c] for c, name in enumerate(CHANNELS)}
    return Recording(manifest, Stream(t, columns), table=Stream(t, {"shaft_angle": read}))


def test_turning_weighs_less_where_the_encoder_is_coarse():
    coarse = block_means(full_rate(on_a_shaft(np.radians(0.1))), 25.0)
    about = coarse.weight[:, 2]
    moving = (coarse.t > 22.0) & (coarse.t < 38.0)
    assert np.median(about[moving]) < 0.3 * np.median(about[coarse.t < 18.0])
    assert np.median(coarse.weight[moving, 0]) > 0.7  # across the shaft nothing is coarse


def test_an_exact_reference_leaves_the_weights_as_they_are():
    full = full_rate(on_a_shaft(0.0))
    exact = block_means(replace(full, reference_noise=EXACT), 25.0)
    assert block_means(full, 25.0).weight == pytest.approx(exact.weight, rel=1e-3, abs=1e-3)


def test_readings_are_compared_only_up_to_where_poses_tell_the_motion():
    full = full_rate(recording())
    assert full.motion.tracking is not None
    blocks = block_means(full, 50.0)
    assert blocks.rate == pytest.approx(50.0)
    assert blocks.band <= full.motion.tracking.edge
    assert blocks.used == pytest.approx(2.0 * blocks.band / 50.0 * (blocks.weight > 0).sum(), abs=1)


def test_what_follows_products_of_rates_is_predicted_alike_on_blocks_and_rows():
    reference = poses(turn_noise=0.01, place_noise=0.01)  # tells slow motion only
    full = full_rate(recording(reference=reference))
    standard = Model.of(STANDARD_TERMS)
    arm = standard.with_term(LEVER_ARM)
    arm.values[-3:] = 0.1, 0.05, -0.1
    added = arm.prediction(full.motion) - standard.prediction(full.motion)
    blocks = block_means(replace(full, readings=added), 50.0)
    by_blocks = arm.prediction(blocks.motion) - standard.prediction(blocks.motion)
    used = blocks.weight[:, 3] > 0
    off = (by_blocks - blocks.readings)[used, 3:]
    assert off.std() < 0.01 * blocks.readings[used, 3:].std()


def test_blocks_beside_a_gap_of_the_encoders_are_used_by_no_effect():
    """Delays and filters make a reading of its neighbours, which are not known there."""
    rests = rested()
    axis = TableAxis(name="table", direction=(0.0, 0.0, 1.0))
    station = rests.manifest.station.model_copy(update={"table_axes": (axis,)})
    t = rests.imu.t[(rests.imu.t < 20.0) | (rests.imu.t > 21.0)]
    turned = replace(
        rests,
        manifest=rests.manifest.model_copy(update={"station": station}),
        table=Stream(t, {"table_angle": np.zeros(len(t))}),
    )
    blocks = block_means(full_rate(turned), 25.0)
    unused = blocks.t[blocks.weight[:, 0] == 0.0]
    assert unused.min() == pytest.approx(20.0 - 5 / 25.0, abs=0.06)
    assert unused.max() == pytest.approx(21.0 + 5 / 25.0, abs=0.06)


def test_rows_stamped_in_batches_leave_no_block_without_a_row():
    full = full_rate(on_a_shaft(np.radians(0.01)))
    late = 0.0075 * (4 - np.arange(len(full.motion.t)) % 5)  # s: stamped as each fifth arrives
    batches = replace(full, motion=replace(full.motion, t=full.motion.t + late - late[0]))
    assert (block_means(batches, 50.0).weight[:, 0] > 0.0).mean() > 0.9


def test_a_recording_whose_motion_is_nowhere_known_on_end_is_refused():
    full = full_rate(rested())
    with pytest.raises(Unusable, match="known motion"):
        block_means(full, 25.0, np.ones(full.readings.shape, bool))
