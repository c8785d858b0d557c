"""A rough case as a recording, with its truth beside it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from schemas.recording import ACCEL, GYRO, Manifest, Recording, Stream
from tests.proof.plant import simulate as plain
from tests.proof.plant.case import draw_unit, generator
from tests.proof.plant.effects.base import Effect
from tests.proof.plant.rough.forms import KNOWN, Logged, Rows, rough_effects
from tests.proof.plant.rough.runs import (
    ByHand,
    RoughCase,
    RoughSetting,
    felt,
    misread,
    move_by_hand,
    read_encoder,
    scattered,
    setting_of,
    track,
)
from tests.proof.plant.simulate import (
    at_times,
    clock,
    converted,
    drive,
    motions_of,
    read_analog,
    read_shaken,
    sensor_noise,
)
from tests.proof.plant.world import Motion, World, weather

REST_NOISE = 0.02  # K, of the unit's own thermometer


@dataclass(frozen=True)
class Played:
    """recording: what is handed out. The rest is sealed.

    truth: (n, 6), what reaches the log without noise. reported: (n, 6), rates and specific force
    at the recorded stamps that a perfect reading of the reference would give, its turn, tilt and
    delay known. misread: (n, 6), what the reference's own noise adds to those.
    """

    rough: RoughCase
    recording: Recording
    effects: tuple[Effect, ...]
    truth: np.ndarray
    reported: np.ndarray
    misread: np.ndarray
    sealed: dict[str, Any]


@dataclass(frozen=True)
class _Moved:
    """The motion that the unit feels, the one that is reported, and the body if a hand moved it."""

    felt: Motion
    reported: Motion
    hand: ByHand | None = None

    def place(self, t: np.ndarray) -> np.ndarray | None:
        """Where the body is at times t (n,) s: (3, n) m; None on a table."""
        if self.hand is None:
            return None
        start, step = float(self.hand.t[0]), self.reported.step
        return at_times(self.hand.place, start, step, t)


def play(rough: RoughCase) -> Played:
    """Plays a case with noise, limits, codes and log. Raises ValueError for an impossible case."""
    case = rough.case
    setting = setting_of(rough)
    effects = rough_effects(setting)
    moved = _motions(setting, effects)
    reported = moved.reported
    world = World(setting, moved.felt)
    device, true_time = clock(case, setting.plan, effects)
    gaps = np.empty(0, dtype=int)
    analog = read_analog(world, effects, true_time, gaps)
    _, steps = converted(case, effects, analog)
    noisy = analog + read_shaken(world, effects, true_time, gaps) + sensor_noise(case, len(device))
    for effect in effects:
        if (limits := effect.limits()) is not None:
            noisy = np.clip(noisy, -limits[:, None], limits[:, None])
    stamps = np.arange(len(device)) / case.rate_hz
    rows = _logged(Rows(stamps, noisy, steps), effects)
    stamp = scattered(generator(case.seed, "stamps"), rows.stamp, rough.stamp_jitter)
    regular = np.concatenate([reported.rates, reported.force])
    reference = _reference(setting, moved, stamp)
    wrong = misread(rough, setting.plan, reference, reported, stamps, moved.place(stamps))
    readings = Stream(stamp, dict(zip(GYRO + ACCEL, rows.readings, strict=True)))
    return Played(
        rough=rough,
        recording=_recording(setting, readings, reference, true_time),
        effects=effects,
        truth=analog.T,
        reported=at_times(regular, float(reported.t[0]), reported.step, stamp).T,
        misread=wrong.T,
        sealed=_sealed(setting, effects),
    )


def _motions(setting: RoughSetting, effects: tuple[Effect, ...]) -> _Moved:
    rough = setting.rough
    t, motor = drive(rough.case, setting.plan)
    if rough.tracking is None:
        return _Moved(*motions_of(setting, effects, t, motor))
    hand = move_by_hand(rough, t)
    gravity = rough.case.gravity_m_s2
    at_arm = felt(hand, gravity, np.array(rough.tracking.arm))
    return _Moved(at_arm, felt(hand, gravity, np.zeros(3)), hand)


def _reference(setting: RoughSetting, moved: _Moved, rows: np.ndarray) -> Stream:
    rough = setting.rough
    if rough.tracking is not None and moved.hand is not None:
        return track(rough, rough.tracking, moved.hand, rows)
    if rough.encoder is None:
        raise ValueError("a rough case needs an encoder, or tracking for a body moved by hand")
    return read_encoder(rough, rough.encoder, setting.plan, moved.reported)


def _logged(rows: Rows, effects: tuple[Effect, ...]) -> Rows:
    """Rows as written: what acts ahead of the converter, the codes, then the log."""
    own = [effect for effect in effects if isinstance(effect, Logged)]
    for effect in own:
        if effect.before_codes:
            rows = effect.logged(rows)
    steps = rows.step[:, None]
    rows = Rows(rows.stamp, np.round(rows.readings / steps) * steps, rows.step)
    for effect in own:
        if not effect.before_codes:
            rows = effect.logged(rows)
    return rows


def _recording(
    setting: RoughSetting, readings: Stream, reference: Stream, true_time: np.ndarray
) -> Recording:
    case = setting.case
    if case.temperature_recorded:
        own = weather(case, true_time).temperature
        rng = generator(case.seed, "thermometer")
        own = np.round(own + REST_NOISE * rng.standard_normal(len(own)), 3)
        readings = Stream(readings.t, {**readings.columns, "temperature": own})
    by_hand = setting.rough.tracking is not None
    return Recording(
        manifest=_manifest(setting),
        imu=readings,
        table=None if by_hand else reference,
        reference=reference if by_hand else None,
        environment=plain.room_stream(case, setting.plan) if setting.rough.run == "table" else None,
    )


def _manifest(setting: RoughSetting) -> Manifest:
    """What the recording's program would write: it knows no effect."""
    rough = setting.rough
    declared = plain.manifest_of(setting.case, setting.plan).model_dump(
        mode="json", exclude_none=True
    )
    declared["recording_id"] = f"rough_{rough.case.seed}"
    if rough.run == "table":
        return Manifest.model_validate(declared)
    streams = {"imu": "imu.parquet"}
    if rough.tracking is not None:
        streams["reference"] = "reference.parquet"
        declared["station"] = declared["station"] | {"table_axes": None, "heading_deg": None}
    else:
        streams["table"] = "table.parquet"
    return Manifest.model_validate(declared | {"streams": streams, "segments": None})


def _sealed(setting: RoughSetting, effects: tuple[Effect, ...]) -> dict[str, Any]:
    """The truth as plain data: every parameter in SI with its unit."""
    rough = setting.rough
    return {
        "case": rough.model_dump(mode="json"),
        "effects": [
            {
                "called": call.name,
                "name": effect.name,
                "parameters": dict(effect.parameters),
                "units": dict(effect.units),
            }
            for call in rough.case.effects
            for effect in effects
            if call.name == getattr(effect, "form", effect.name)
        ],
        "nuisances": nuisances(rough),
        "parameters": setting.unit.parameters(),
    }


def nuisances(rough: RoughCase) -> dict[str, dict[str, Any]]:
    """What belongs to the reference and is no fault of the unit, by catalogue name: true where
    drawn, in the definitions of the catalogue's parameters."""
    found: dict[str, dict[str, Any]] = {}
    tracking, encoder = rough.tracking, rough.encoder
    of_table = encoder.jitter if encoder is not None else 0.0
    if rough.stamp_jitter or of_table:
        found["timestamp_jitter"] = {"sigma": rough.stamp_jitter, "of_table": of_table}
    if tracking is not None:
        if tracking.delay:
            found["time_offset"] = {"seconds": -tracking.delay}
        if any(tracking.turn) or any(tracking.tilt):
            found["reference_frame"] = {"turn": tracking.turn, "tilt": tracking.tilt}
        if any(tracking.arm):
            found["lever_arm"] = {"r": tracking.arm}
    return found


# How far an effect stands above everything else in a rough recording.
#
# z² = Σ |S(f)|² / L(f): S, what the effect changes in the misfit, L, the spectrum of the misfit
# without it: noise, the reference's errors and whatever else is hidden. From both the standard's
# columns took their part. With nothing but noise left, z is the visibility of the plain plant.
#
# S is of readings before noise and rounding: each code that comes out otherwise, as the smallest
# change makes of many, is a difference as large as a step, and chance. Only what a logger does is
# seen in the codes alone.
#
# What an effect adds at random, as a table's vibration that folds into the band, is no part of
# its truth and would look the same whatever rectifies it: it belongs to L. Without an effect that
# shakes the samples means, therefore, the same recording with the effect's strength at zero.

BY_SIZE = ("range_setting", "axis_mapping")  # the standard's columns take them: their size tells
FEWEST = 6  # frequencies in a band whose power is averaged
BANDS = 60
CLOSE = 0.15  # relative, of z asked for
TRIES = 8
SMALLEST, LARGEST = 1e-3, 15.0  # strengths: from 17 on some are beyond what is plausible


def standing(played: Played, rest: Played, by_size: bool = False) -> float:
    """z of what `played` has beyond `rest`, the same recording without it."""
    count = min(len(played.reported), len(rest.reported))
    signal = _difference(played, rest, count).T
    left = _misfit(rest, _as_logged(rest), rest.misread)[:count].T
    total = 0.0
    for channel in range(6):
        columns = _columns(rest.reported[:count], channel)
        series = signal[channel] if by_size else _without(columns, signal[channel])
        total += _above(series, _without(columns, left[channel]))
    return float(np.sqrt(total))


def without(rough: RoughCase, called: str) -> RoughCase:
    """The case with all of one effect gone but the random motion of the samples it comes with."""
    if KNOWN[called].shake is not Effect.shake:
        return rough.with_strength(called, 0.0)
    return rough.without(called)


def at_standing(rough: RoughCase, called: str, z: float) -> tuple[RoughCase, float]:
    """The case with one effect's strength set so that it stands z above the rest, and z reached.

    What has no size, starts at a threshold or cannot grow so far gets as near as it can.
    """
    effect, rest = KNOWN[called], play(without(rough, called))
    if not effect.sized and vars(effect).get("at") is None:
        return rough, standing(play(rough), rest, called in BY_SIZE)
    strength, tried = 1.0, list[tuple[float, float]]()
    for _ in range(TRIES):
        reached = standing(play(rough.with_strength(called, strength)), rest)
        tried.append((strength, reached))
        if abs(reached / z - 1.0) < CLOSE:
            break
        below = max((s for s, r in tried if r < z), default=0.0)
        above = min((s for s, r in tried if r >= z), default=np.inf)
        wanted = strength * float(np.clip(z / max(reached, 1e-9), 0.05, 20.0))
        if not below < wanted < above:
            wanted = float(np.sqrt(max(below, SMALLEST) * min(above, LARGEST)))
        strength = float(np.clip(wanted, SMALLEST, LARGEST))
    best = min(tried, key=lambda pair: abs(np.log(max(pair[1], 1e-9) / z)))
    return rough.with_strength(called, best[0]), best[1]


def _difference(played: Played, rest: Played, count: int) -> np.ndarray:
    """(count, 6) what the misfit has beyond that of the rest."""
    analog = _misfit(played, played.truth)[:count] - _misfit(rest, rest.truth)[:count]
    if analog.any():
        return analog
    return _misfit(played, _as_logged(played))[:count] - _misfit(rest, _as_logged(rest))[:count]


def _as_logged(played: Played) -> np.ndarray:
    return played.recording.imu.stack(GYRO + ACCEL)


def _misfit(played: Played, readings: np.ndarray, misread: np.ndarray | None = None) -> np.ndarray:
    """Readings (n, 6) less the true standard's model on the reported motion.

    misread: (n, 6) what the reference's noise adds to it.
    """
    reported = played.reported[: len(readings)]
    if misread is not None:
        reported = reported + misread[: len(reported)]
    unit = draw_unit(played.rough.case.seed)
    modelled = unit.reads(reported[:, :3].T, reported[:, 3:].T).T
    return np.asarray(readings[: len(reported)] - modelled)


def _columns(reported: np.ndarray, channel: int) -> np.ndarray:
    """The standard's columns of a channel, those that vary, at one size; and the constant."""
    rates, force = reported[:, :3], reported[:, 3:]
    more = rates if channel < 3 else np.delete(rates, channel - 3, axis=1) ** 2
    columns = np.hstack([force, more])
    columns = columns - columns.mean(axis=0)
    size = np.sqrt((columns**2).mean(axis=0))
    kept = columns[:, size > 1e-6] / size[size > 1e-6]
    return np.column_stack([np.ones(len(reported)), kept])


def _without(columns: np.ndarray, series: np.ndarray) -> np.ndarray:
    found, *_ = np.linalg.lstsq(columns, series, rcond=1e-10)
    return np.asarray(series - columns @ found)


def _above(signal: np.ndarray, left: np.ndarray) -> float:
    """Σ over frequencies of signal power over the power of what is left, band by band."""
    observation, rest = (np.abs(np.fft.rfft(series)[1:]) ** 2 for series in (signal, left))
    edges = np.unique(np.geomspace(FEWEST, len(rest), BANDS).astype(int))
    edges = np.concatenate([[0], edges])
    power = np.add.reduceat(rest, edges[:-1]) / np.diff(edges)
    return float((2.0 * np.add.reduceat(observation, edges[:-1]) / power).sum())
