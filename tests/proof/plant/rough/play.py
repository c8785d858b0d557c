"""A rough case as a recording, with its truth beside it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from schemas.recording import ACCEL, GYRO, Manifest, Recording, Stream
from tests.proof.plant import recording as plain
from tests.proof.plant.case import Case
from tests.proof.plant.effects.base import Effect
from tests.proof.plant.grades import channel_noise
from tests.proof.plant.noise import noise
from tests.proof.plant.noise_free_case import (
    clock,
    converted,
    drive,
    motions_of,
    read_analog,
    read_shaken,
)
from tests.proof.plant.rough.case import RoughCase
from tests.proof.plant.rough.effects import rough_effects
from tests.proof.plant.rough.logged import Logged, Rows
from tests.proof.plant.rough.reference import misread, read_encoder, scattered, track
from tests.proof.plant.rough.runs import ByHand, RoughSetting, felt, move_by_hand, setting_of
from tests.proof.plant.sampling import at_times
from tests.proof.plant.seeds import generator
from tests.proof.plant.weather import weather
from tests.proof.plant.world import Motion, World

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
    noisy = analog + read_shaken(world, effects, true_time, gaps) + _noise(case, len(device))
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


def _noise(case: Case, count: int) -> np.ndarray:
    """(6, n): every channel its own, the same whatever the effects."""
    return np.stack([
        noise(generator(case.seed, f"noise {channel}"), model, count, case.rate_hz)
        for channel, model in enumerate(channel_noise(case.grade))
    ])  # fmt: skip


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
