"""What is left is held against noise read off rests, and not off what a model leaves."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from engine_run import NOISY, RATE, motion, noise, observed, read, segments
from scipy.fft import irfft, rfft, rfftfreq

from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.left_over import (
    Examined,
    LeftOver,
    band_of,
    loops_both_ways,
    made_by_placing,
    remainder,
    rest_noise,
    unseen_turning,
)
from tasks.explain.evidence.scrutiny import Scrutiny
from tasks.explain.explanation import Refusal
from tasks.explain.inputs.blocks import FullRate
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.design import NormalEquations
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.stepwise import Selected, Selection
from tasks.model.term import Term, each_axis
from tasks.model.terms.electronics import BANDWIDTH_BY_TRIAD
from tasks.model.terms.geometry import LEVER_ARM, STRUCTURAL_COMPLIANCE
from tasks.model.terms.gyro import gyro_dead_band
from tasks.motion.pose import Tracking
from tasks.motion.reference_noise import ReferenceNoise
from tasks.motion.whole import Motion

# What looks like one kind of physics alone, and is something else, has not its name.

RUN = motion()
BAND = gyro_dead_band(0.02)
PARAMETERS = tuple(
    one
    for width in ("0.2", "0.8")
    for one in each_axis(f"amplitude_{width}", "h", ("m/s2", "m/s2", 1.0))
)
U = np.full(6, 0.01)
ROWS = 20  # of each segment, and between them
SHAKEN, NONE = motion(), np.zeros(0)


def refused(made: np.ndarray, reported: Motion) -> Refusal | None:
    """Why a dead band fitted to readings (n, 6) beside what the reference told has no name."""
    selected = Selected(Candidate(BAND, (0, 1, 2), (0, 1, 2), 1), 100.0, 90.0, ())
    nothing = NormalEquations(np.zeros((0, 0)), np.zeros(0), np.zeros(0), 0.0)
    blocks = replace(observed(made, RUN), motion=reported)
    fit = FittedSelection.of(Selection((selected,), NOISY, 0.0, nothing), blocks, RATE)
    return unseen_turning(Examined(Evidence.of(fit), 0, NONE, NONE))


def test_one_that_takes_off_faster_rates_too_keeps_its_name() -> None:
    made = read(RUN, (BAND, [-1.0, -0.5, -0.8])) + noise(len(RUN.t), 61, NOISY)
    assert refused(made, RUN) is None


@pytest.mark.parametrize("error", [2e-3, 0.02])  # rad/s, now and then as fast as a turn
def test_what_takes_off_the_errors_of_rests_alone_has_no_name(error: float) -> None:
    resting = ~RUN.rate.any(axis=1, keepdims=True)
    errors = error * np.random.default_rng(62).standard_t(2.0, RUN.rate.shape)
    reported = replace(RUN, rate=RUN.rate + resting * errors)
    refusal = refused(read(RUN) + noise(len(RUN.t), 61, NOISY), reported)
    assert refusal is not None
    assert refusal.kind == "undetermined"


def memory(effect: str, values: np.ndarray) -> Examined:
    """A finding with the weights of two widths of each axis."""
    groups = [SimpleNamespace(name=effect)]
    evidence = SimpleNamespace(groups=groups, parameters=lambda _: PARAMETERS)
    return Examined(cast(Evidence, evidence), 0, values, U)


@pytest.mark.parametrize(
    ("values", "refused"),
    [
        ((0.1, -0.1, 0.0, 0.3, -0.3, 0.2), False),  # each axis has a direction of its own
        ((0.1, 0.0, 0.0, -0.3, 0.0, 0.0), True),
        ((0.1, 0.0, 0.0, -0.015, 0.0, 0.0), False),  # within its U
    ],
)
def test_clear_weights_of_both_signs_in_one_channel_are_no_memory(
    values: tuple[float, ...], refused: bool
) -> None:
    found = loops_both_ways(memory("hysteresis", np.array(values)))
    assert (found is not None and found.kind == "both_ways") == refused


def test_other_effects_may_have_parameters_of_both_signs() -> None:
    values = np.array([0.1, 0.0, 0.0, -0.3, 0.0, 0.0])
    assert loops_both_ways(memory("temperature_bias", values)) is None


def placed(rests: int, term: Term, parameters: int = 6, **motion: Any) -> Examined:
    """A run of rests with a turn after each, told by labels unless `motion` says otherwise."""
    segment = np.tile(np.repeat([0, -1], ROWS), rests)
    segment[segment == 0] = np.repeat(np.arange(rests), ROWS)
    rate = np.where(segment[:, None] >= 0, 0.0, 0.3) * np.ones(3)
    fields = {"axes": None, "tracking": None, "rate": rate} | motion
    blocks = SimpleNamespace(motion=SimpleNamespace(**fields), segment=segment)
    evidence = SimpleNamespace(
        fit=SimpleNamespace(blocks=blocks), own=[(list(range(parameters)), None)],
        groups=[SimpleNamespace(terms=(term,), name=term.name)],
    )  # fmt: skip
    return Examined(cast(Evidence, evidence), 0, NONE, NONE)


def test_six_labelled_rests_tell_no_fixture_that_bends() -> None:
    refusal = made_by_placing(placed(6, STRUCTURAL_COMPLIANCE))
    assert refusal is not None
    assert (refusal.kind, refusal.name, refusal.value) == ("placed", "structural_compliance", 6)


@pytest.mark.parametrize(
    ("rests", "parameters", "term", "motion"),
    [
        (7, 6, STRUCTURAL_COMPLIANCE, {}),
        (6, 3, STRUCTURAL_COMPLIANCE, {}),
        (6, 6, LEVER_ARM, {}),
        (6, 6, STRUCTURAL_COMPLIANCE, {"axes": object()}),
        (6, 6, STRUCTURAL_COMPLIANCE, {"tracking": object()}),
    ],
    ids=["a rest more", "fewer parameters", "no turn of the body", "encoders", "poses"],
)
def test_what_more_is_known_of_keeps_its_name(
    rests: int, parameters: int, term: Term, motion: dict[str, Any]
) -> None:
    assert made_by_placing(placed(rests, term, parameters, **motion)) is None


def refusal_of_filter(readings: np.ndarray) -> str | None:
    """Why the readings, with noise, do not show a low-pass of each triad; nothing if they do."""
    made = readings + noise(len(SHAKEN.t), 71, NOISY)
    chosen = (Selected(Candidate(BANDWIDTH_BY_TRIAD, (0, 1), (0, 1), 1), 100.0, 90.0, ()),)
    nothing = NormalEquations(np.zeros((0, 0)), np.zeros(0), np.zeros(0), 0.0)
    selection = Selection(chosen, NOISY, 0.0, nothing)
    evidence = Evidence.of(FittedSelection.of(selection, observed(made, SHAKEN), RATE))
    refusal = Scrutiny.of(evidence, 0).refusal
    return refusal and refusal.kind


def on_rubber(frequency: float, damping: float, share: float) -> np.ndarray:
    """Readings (n, 6) of accelerometers that feel a share of a resonance of the specific force."""
    made = read(SHAKEN)
    ratio = rfftfreq(2 * len(made), 1.0 / RATE) / frequency
    excess = 1.0 / (1.0 - ratio**2 + 2j * damping * ratio) - 1.0
    mirrored = np.concatenate([made[:, 3:], made[::-1, 3:]])
    swung = irfft(excess[:, None] * rfft(mirrored, axis=0), axis=0)[: len(made)]
    made[:, 3:] += share * swung
    return made


@pytest.mark.parametrize(("frequency", "damping"), [(7.0, 0.1), (9.0, 0.06), (12.0, 0.15)])
def test_a_mount_that_swings_is_no_filter(frequency: float, damping: float) -> None:
    assert refusal_of_filter(on_rubber(frequency, damping, 1.3)) == "swings"


@pytest.mark.parametrize("seconds", [0.003, 0.008])
def test_a_filter_of_the_accelerometers_keeps_its_name(seconds: float) -> None:
    assert refusal_of_filter(read(SHAKEN, (BANDWIDTH_BY_TRIAD, (0.0, seconds)))) is None


SIGMA = np.repeat([2e-5, 5e-4], 3)
NOTHING = np.zeros((len(RUN.t), 6), bool)


def run(seed: int = 3) -> FullRate:
    readings = read(RUN) + SIGMA * np.random.default_rng(seed).standard_normal((len(RUN.t), 6))
    variance = np.tile([SIGMA[0] ** 2, SIGMA[3] ** 2], (len(segments()) + 1, 1))
    return FullRate(
        readings, RUN, np.full(len(RUN.t), -1), segments(), variance, np.zeros(6),
        np.ones(6, bool),
    )  # fmt: skip


def test_noise_alone_leaves_one_and_nothing_to_explain() -> None:
    left = LeftOver.of(run(), read(RUN), read(RUN), NOTHING)
    assert left.chi2_per_degree == pytest.approx(np.ones(6), abs=0.05)
    assert left.remaining == 0.0
    assert left.explained_share == 1.0


def test_the_share_is_of_the_mismatch_above_noise() -> None:
    full, nominal, found = run(), read(RUN), read(RUN)
    wave = SIGMA[1] * np.sin(40.0 * RUN.t)
    nominal[:, 1] += 10.0 * wave
    found[:, 1] += 5.0 * wave
    assert LeftOver.of(full, nominal, found, NOTHING).explained_share == pytest.approx(
        0.75, abs=0.02
    )


def test_noise_of_the_reference_is_none_of_the_sensor() -> None:
    full = run()
    rough = (
        full.readings - read(RUN) + 1e-3 * np.random.default_rng(4).standard_normal((len(RUN.t), 6))
    )
    assert np.sqrt(rest_noise(full, rough))[:3] == pytest.approx(SIGMA[:3], rel=0.1)


def test_a_unit_that_never_rests_has_the_noise_of_its_neighbouring_samples() -> None:
    full = run()
    moving = replace(RUN, rate=RUN.rate + 0.5)
    noise = rest_noise(replace(full, motion=moving), full.readings - read(RUN))
    assert np.sqrt(noise) == pytest.approx(SIGMA, rel=0.3)


def test_motion_beyond_the_band_of_tracked_poses_is_not_held_against_them() -> None:
    tracking = Tracking(1.0, 1.0, 0.01, 1e-12, 1e-14)
    full = replace(run(), reference_noise=ReferenceNoise(tracking=tracking))
    fast, slow = read(RUN), read(RUN)
    fast[:, 2] += 10.0 * SIGMA[2] * np.sin(2.0 * np.pi * 6.25 * RUN.t)
    slow[:, 2] += 10.0 * SIGMA[2] * np.sin(2.0 * np.pi * 0.1 * RUN.t)
    beyond = LeftOver.of(full, fast, fast, NOTHING)
    within = LeftOver.of(full, slow, slow, NOTHING)
    exact = LeftOver.of(run(), fast, fast, NOTHING)
    assert beyond.chi2_per_degree[2] < 0.15 * exact.chi2_per_degree[2]
    assert within.chi2_per_degree[2] > 50.0


# What nothing explains is told of where it stands clear of the noise of unit and reference.

SHAPE = (len(RUN.t), 6)
FREQUENCY = 3.0  # Hz


def run_left_over_remainder() -> FullRate:
    """The motion as read with noise."""
    readings = read(RUN) + SIGMA * np.random.default_rng(5).standard_normal(SHAPE)
    variance = np.tile([SIGMA[0] ** 2, SIGMA[3] ** 2], (len(segments()) + 1, 1))
    return FullRate(
        readings, RUN, np.full(len(RUN.t), -1), segments(), variance, np.zeros(6), np.ones(6, bool)
    )


def predicted(wave: float = 0.0) -> np.ndarray:
    """What the model says, in accelerometer y wrong by a wave of so many σ."""
    found = read(RUN)
    found[:, 4] += wave * SIGMA[4] * np.sin(2.0 * np.pi * FREQUENCY * RUN.t)
    return found


def left_of(full: FullRate, found: np.ndarray) -> LeftOver:
    return LeftOver.of(full, found, found, np.zeros(SHAPE, bool))


def test_noise_alone_is_not_told_of() -> None:
    full, found = run_left_over_remainder(), predicted()
    assert remainder(full, found, left_of(full, found)) is None


def test_what_is_left_is_told_of_without_a_name_in_its_channel_and_adds_nothing() -> None:
    full, found = run_left_over_remainder(), predicted(wave=3.0)
    rest = remainder(full, found, left_of(full, found))
    assert rest is not None
    assert (rest.effect, rest.channels, rest.share) == ("unnamed", (4,), 0.0)
    assert not rest.contribution.any()


def test_its_band_holds_the_frequency_of_the_wave() -> None:
    full, found = run_left_over_remainder(), predicted(wave=3.0)
    low, high = band_of(full, found, left_of(full, found), (4,))
    assert low == pytest.approx(FREQUENCY, abs=0.2)
    assert high == pytest.approx(FREQUENCY, abs=0.2)


def test_what_may_be_the_noise_of_the_reference_is_not_told_of() -> None:
    full, found = run_left_over_remainder(), predicted(wave=3.0)
    left = left_of(full, found)
    assert left.chi2_per_degree[4] > 2.0
    assert remainder(full, found, replace(left, reference=0.5 * left.noise)) is None


def test_a_residual_of_less_power_than_noise_has_a_band_all_the_same() -> None:
    """As where the few readings that are above the noise are masked."""
    full, found = run_left_over_remainder(), read(RUN)
    full = replace(full, readings=found)
    low, high = band_of(full, found, left_of(full, found), (4,))
    assert 0.0 < low <= high
