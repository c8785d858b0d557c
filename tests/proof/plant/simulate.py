"""A case as a recording, with its truth beside it."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.stats import norm

from schemas.recording import ACCEL, GYRO, Manifest, Recording, Stream
from tests.proof.plant.case import (
    ACCEL_NOISE,
    GYRO_NOISE,
    Case,
    Noise,
    Plan,
    UnitErrors,
    about,
    channel_noise,
    from_vector,
    generator,
    inverse,
    product,
    rates,
    slope,
    turned,
)
from tests.proof.plant.effects import effects_of
from tests.proof.plant.effects.base import EARTH, Effect, Link
from tests.proof.plant.procedures import plan_of
from tests.proof.plant.world import Motion, Setting, World, weather

# Kinematics: from shaft angles to what the unit feels, by composing and differencing.

MARGIN = 2  # points on each side that differences use up
UP = np.array([0.0, 0.0, 1.0])


def move(
    plan: Plan,
    t: np.ndarray,
    shaft: np.ndarray,
    heading: float,
    gravity: float,
    effects: Sequence[Effect] = (),
) -> Motion:
    """The motion of the unit at all but two times at each end.

    shaft: (axes, n) rad at times t (n,). heading: rad. gravity: m/s². Each fixing is played for
    itself and the takes are put one behind the other, as a paused recording would.
    """
    takes = _takes(plan, t, effects)
    played = [
        _play(plan, fixing, t[low:high], shaft[:, low:high], heading, gravity, effects)
        for fixing, low, high in takes
    ]
    inner = slice(MARGIN, -MARGIN)
    attitude, rate, force = (np.concatenate(parts, axis=1) for parts in zip(*played, strict=True))
    return Motion(t[inner], shaft[:, inner], attitude, rate, force, seams(plan, effects))


def seams(plan: Plan, effects: Sequence[Effect]) -> np.ndarray:
    """Times in s at which one take ends and the next begins; none where nothing is re-fixed."""
    moved = any(effect.fixing_error(0) is not None for effect in effects)
    return plan.fixing_times()[1:] if moved or len(set(plan.mounts)) > 1 else np.empty(0)


def _takes(plan: Plan, t: np.ndarray, effects: Sequence[Effect]) -> list[tuple[int, int, int]]:
    """(fixing, first, past last) of each take, with the margin on both sides."""
    edges = [MARGIN, *np.searchsorted(t, seams(plan, effects)), len(t) - MARGIN]
    return [
        (fixing, int(low) - MARGIN, int(high) + MARGIN)
        for fixing, (low, high) in enumerate(pairwise(edges))
    ]


def _play(
    plan: Plan,
    fixing: int,
    t: np.ndarray,
    shaft: np.ndarray,
    heading: float,
    gravity: float,
    effects: Sequence[Effect],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Attitude (4, n − 4), rates and specific force (3, n − 4) of one take."""
    chain: list[Link] = [("heading", about(UP, -heading))]
    for name, direction, angle in zip(plan.table.names, plan.table.directions, shaft, strict=True):
        chain.append((name, about(np.array(direction), angle)))
    chain.append(("mount", np.array(plan.mounts[fixing]).reshape(4, 1)))
    for effect in effects:
        error = effect.fixing_error(fixing)
        if error is not None:
            chain.append(("misfit", from_vector(error)))
        chain = effect.links(chain, t, shaft)
    ground = [q for name, q in chain if name == EARTH]
    attitude = reduce(product, (q for name, q in chain if name != EARTH))
    if attitude.shape[1] == 1:
        attitude = np.repeat(attitude, len(t), axis=1)
    step = float(t[1] - t[0])
    attitude = _bent(attitude, step, effects)
    inertial = reduce(product, [*ground, attitude])
    return (
        attitude[:, MARGIN:-MARGIN],
        rates(inertial, step),
        _force(attitude, step, gravity, effects),
    )


def _bent(attitude: np.ndarray, step: float, effects: Sequence[Effect]) -> np.ndarray:
    """The attitude after the fixture gave way to the loads of the rigid motion."""
    rigid = None
    for effect in effects:
        if rigid is None and type(effect).bend is not Effect.bend:
            rigid = np.pad(rates(attitude, step), ((0, 0), (MARGIN, MARGIN)), mode="edge")
        bend = effect.bend(rigid) if rigid is not None else None
        if bend is not None:
            attitude = product(attitude, from_vector(bend))
    return attitude


def _force(
    attitude: np.ndarray, step: float, gravity: float, effects: Sequence[Effect]
) -> np.ndarray:
    """What each accelerometer feels along its axis, (3, n − 4) m/s²."""
    back = inverse(attitude[:, MARGIN:-MARGIN])
    force = turned(back, gravity * UP)
    arms = [arm for arm in (effect.arms() for effect in effects) if arm is not None]
    if not arms:
        return force
    places, share = np.unique(np.sum(arms, axis=0), axis=0, return_inverse=True)
    for number, place in enumerate(places):
        position = turned(attitude, place)
        acceleration = np.diff(position[:, 1:-1], 2, axis=1) / step**2
        felt = turned(back, acceleration)
        own = share.ravel() == number
        force[own] += felt[own]
    return force


# The unit's electronics: filter, clock, converter. From the fine grid to its samples.


def filtered(signal: np.ndarray, step: float, effects: Sequence[Effect]) -> np.ndarray:
    """Six channels (6, n) after the analogue path; unchanged where nothing filters.

    The transfer function is applied in the frequency domain, so it is that of the analogue
    circuit, not of a discrete likeness; the ends are held to keep the wrap-around away.
    """
    length = next_fast_len(signal.shape[1] + int(2.0 / step), real=True)
    frequency = rfftfreq(length, step)
    passed = [answer for effect in effects if (answer := effect.response(frequency)) is not None]
    if not passed:
        return signal
    transfer = np.prod(passed, axis=0)
    after = (length - signal.shape[1]) // 2
    held = np.empty(length)
    result = np.empty_like(signal)
    for channel, series in enumerate(signal):
        held[: len(series)] = series
        held[len(series) : len(series) + after] = series[-1]
        held[len(series) + after :] = series[0]
        result[channel] = irfft(rfft(held) * transfer, length)[: len(series)]
    return result


def at_times(signal: np.ndarray, start: float, step: float, times: np.ndarray) -> np.ndarray:
    """Channels (c, n) on the grid start, start + step, … at other times, cubic between points.

    Beyond the ends, which lie at rest, the signal stays what it was.
    """
    place = np.clip((times - start) / step, 0.0, signal.shape[1] - 1.0)
    whole = np.rint(place)
    if np.abs(place - whole).max(initial=0.0) < 1e-6:
        return np.asarray(signal[:, whole.astype(int)])
    before = np.clip(np.floor(place).astype(int), 1, signal.shape[1] - 3)
    u = place - before
    return np.asarray(
        signal[:, before - 1] * (-u * (u - 1.0) * (u - 2.0) / 6.0)
        + signal[:, before] * ((u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0)
        + signal[:, before + 1] * (-(u + 1.0) * u * (u - 2.0) / 2.0)
        + signal[:, before + 2] * ((u + 1.0) * u * (u - 1.0) / 6.0)
    )


def mean_reading(signal: np.ndarray, steps: np.ndarray, deviations: np.ndarray) -> np.ndarray:
    """What channels (6, n) read on average when noise of these deviations meets these steps.

    The mean of a rounded Gaussian variable, as a Fourier series of the rounding error (Widrow and
    Kollár, Quantization Noise, 2008); with steps smaller than the noise it is the signal itself.
    """
    mean = signal.copy()
    for channel, (step, deviation) in enumerate(zip(steps, deviations, strict=True)):
        turns = 2.0 * np.pi * signal[channel] / step
        for order in range(1, 200):
            left = np.exp(-2.0 * (np.pi * order * deviation / step) ** 2)
            if left < 1e-6:
                break
            mean[channel] += step / np.pi * (-1.0) ** order / order * left * np.sin(order * turns)
    return mean


def mean_limited(signal: np.ndarray, limits: np.ndarray, deviations: np.ndarray) -> np.ndarray:
    """What channels (6, n) read on average when noise of these deviations meets ± limits (6,).

    E[min(s + noise, L)] = s − σ·(φ(d) − d·Φ(−d)) with d = (L − s)/σ, and the same from below.
    """
    mean = signal.copy()
    for channel, (limit, deviation) in enumerate(zip(limits, deviations, strict=True)):
        for side in (1.0, -1.0):
            room = (limit - side * signal[channel]) / deviation
            near = room < 6.0
            lost = norm.pdf(room[near]) - room[near] * norm.cdf(-room[near])
            mean[channel, near] -= side * deviation * lost
    return mean


# Noise with a given spectrum.


def noise(rng: np.random.Generator, model: Noise, count: int, rate: float) -> np.ndarray:
    """White and flicker noise (count,) at `rate` samples per second.

    A Gaussian process with exactly the stated density, twice as long as needed so that its end
    does not know its beginning: flicker reaches down to half the inverse of the duration.
    """
    length = next_fast_len(2 * count, real=True)
    frequency = rfftfreq(length, 1.0 / rate)[1:]
    # a one-sided density S gives each pair of bins the mean square |X|² = S · rate · length / 2
    amplitude = np.sqrt(model.density(frequency) * rate * length / 4.0)
    spectrum = np.zeros(len(frequency) + 1, dtype=complex)
    spectrum[1:] = amplitude * (
        rng.standard_normal(len(frequency)) + 1j * rng.standard_normal(len(frequency))
    )
    if length % 2 == 0:
        spectrum[-1] = spectrum[-1].real * np.sqrt(2.0)
    return np.asarray(irfft(spectrum, length)[:count])


# One case without noise: what the unit would have read, and what the standard's model says.

FINEST = 500  # Hz: the fine grid has at least so many points a second
PAD = 1.0  # s at rest before and after the run
SERVO = 5e-7  # rad: what the drive leaves of the motor's poles; encoder and shaft both follow it
POLES = 12
OF_MOTION = ("gravity", "shaft", "encoder", "links", "fixing_error", "arms", "bend")


@dataclass(frozen=True)
class NoiseFree:
    """stamp: (n,) s, as recorded. analog, truth, nominal: (6, n), rad/s and m/s².

    analog: what reaches the converter, where noise joins it.
    truth: the reading that many runs with other noise would have on average. It has saturation
    and an effect's coarse steps, both as the white noise softens them, and not the grade's own
    rounding, which the noise hides. nominal: the true standard parameters
    on the motion that the table reports and the gravity told, at the recorded stamps.
    reported: rates and specific force of that motion, (6, n). shaken: random, not in the truth.
    table_t, table_angles, table_rates: the table's stream without its own noise.
    """

    plan: Plan
    effects: tuple[Effect, ...]
    unit: UnitErrors
    stamp: np.ndarray
    true_time: np.ndarray
    analog: np.ndarray
    truth: np.ndarray
    nominal: np.ndarray
    reported: np.ndarray
    shaken: np.ndarray
    steps: np.ndarray
    table_t: np.ndarray
    table_angles: np.ndarray
    table_rates: np.ndarray


def without_noise(case: Case) -> NoiseFree:
    """Plays a case. Raises ValueError for effects that it cannot have."""
    plan = plan_of(case)
    setting = Setting(case, plan)
    effects = effects_of(case, setting)
    t, motor = drive(case, plan)
    motion, reported = motions_of(setting, effects, t, motor)
    world = World(setting, motion)
    device, true_time = clock(case, plan, effects)
    gaps = np.searchsorted(device, motion.seams)
    analog = read_analog(world, effects, true_time, gaps)
    truth, steps = converted(case, effects, analog)
    stamp = np.arange(len(device)) / case.rate_hz
    felt = np.concatenate([reported.rates, reported.force])
    felt = sampled(felt, reported, (), stamp, np.searchsorted(stamp, reported.seams))
    table_t = np.arange(round(plan.duration * case.rate_hz)) / case.rate_hz
    speeds = slope(reported.shaft, reported.step)
    return NoiseFree(
        plan=plan,
        effects=effects,
        unit=world.unit,
        stamp=stamp,
        true_time=true_time,
        analog=analog,
        truth=truth,
        nominal=world.unit.reads(felt[:3], felt[3:]),
        reported=felt,
        shaken=read_shaken(world, effects, true_time, gaps),
        steps=steps,
        table_t=table_t,
        table_angles=at_times(reported.shaft, float(reported.t[0]), reported.step, table_t),
        table_rates=at_times(speeds, float(reported.t[0]), reported.step, table_t),
    )


def read_analog(
    world: World, effects: Sequence[Effect], times: np.ndarray, gaps: np.ndarray
) -> np.ndarray:
    """What reaches the converter, (6, n), without noise."""
    signal = world.unit.reads(world.motion.rates, world.motion.force)
    for effect in effects:
        if (part := effect.sense(world)) is not None:
            signal = signal + part
    analog = sampled(signal, world.motion, effects, times, gaps)
    for effect in effects:
        if (picked := effect.pick_up(times)) is not None:
            analog = analog + picked
    return analog


def read_shaken(
    world: World, effects: Sequence[Effect], times: np.ndarray, gaps: np.ndarray
) -> np.ndarray:
    """The random motion of the samples, (6, n)."""
    shaken = np.zeros((6, len(times)))
    for effect in effects:
        if (rough := effect.shake(world)) is not None:
            shaken += sampled(rough, world.motion, effects, times, gaps)
    return shaken


def fine_rate(case: Case) -> int:
    """Points a second of the fine grid: a multiple of the unit's rate."""
    return case.rate_hz * -(-FINEST // case.rate_hz)


def drive(case: Case, plan: Plan) -> tuple[np.ndarray, np.ndarray]:
    """The fine grid (n,) s and where the drive holds the motors (axes, n) rad."""
    fine = fine_rate(case)
    pad = int(PAD * fine) + MARGIN
    t = np.arange(-pad, int(np.ceil(plan.duration * fine)) + pad) / fine
    motor = plan.angles(t)
    return t, motor + SERVO * np.sin(POLES * motor)


def motions_of(
    setting: Setting, effects: Sequence[Effect], t: np.ndarray, motor: np.ndarray
) -> tuple[Motion, Motion]:
    """The true motion, and the one that the table reports to somebody who trusts it."""
    case, plan = setting.case, setting.plan
    heading = float(np.radians(case.heading_deg))
    moving = [e for e in effects if any(overrides(e, place) for place in OF_MOTION)]
    shaft = read = motor
    gravity = case.gravity_m_s2
    for effect in moving:
        shaft, read = effect.shaft(shaft), effect.encoder(read)
        gravity = effect.gravity(gravity)
    reported = move(plan, t, read, heading, case.gravity_m_s2)
    if not moving:
        return reported, reported
    return move(plan, t, shaft, heading, gravity, moving), reported


def overrides(effect: Effect, place: str) -> bool:
    """Whether an effect acts at a place of the plant."""
    return getattr(type(effect), place) is not getattr(Effect, place)


def clock(case: Case, plan: Plan, effects: Sequence[Effect]) -> tuple[np.ndarray, np.ndarray]:
    """The unit's own time and the true time (n,) s of the samples that arrive."""
    count = round(plan.duration * case.rate_hz)
    kept = np.ones(count, dtype=bool)
    for effect in effects:
        arrives = effect.kept(count)
        kept &= True if arrives is None else arrives
    device = np.flatnonzero(kept) / case.rate_hz
    true = device
    for effect in effects:
        true = effect.true_time(true)
    return device, true


def sampled(
    signal: np.ndarray,
    motion: Motion,
    effects: Sequence[Effect],
    times: np.ndarray,
    gaps: np.ndarray,
) -> np.ndarray:
    """Six channels of the fine grid, filtered and sampled, each take for itself.

    gaps: the samples that begin a new take; the fixing's number follows the stamp.
    """
    plan_edges = [0, *np.searchsorted(motion.t, motion.seams), len(motion.t)]
    edges = [0, *gaps, len(times)]
    late = sum((d for e in effects if (d := e.delays()) is not None), np.zeros(6))
    result = np.empty((6, len(times)))
    for number in range(len(edges) - 1):
        low, high = plan_edges[number], plan_edges[number + 1]
        rows = slice(edges[number], edges[number + 1])
        take = filtered(signal[:, low:high], motion.step, effects)
        start = float(motion.t[low])
        for delay in np.unique(late):
            same = late == delay
            result[same, rows] = at_times(take[same], start, motion.step, times[rows] + delay)
    return result


def converted(
    case: Case, effects: Sequence[Effect], truth: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The truth behind limits and coarse steps, and the steps."""
    own = steps = np.array([noise.step for noise in channel_noise(case.grade)])
    white = np.array([noise.white for noise in channel_noise(case.grade)])
    deviations = white * np.sqrt(case.rate_hz / 2.0)
    for effect in effects:
        if (limits := effect.limits()) is not None:
            truth = mean_limited(truth, limits, deviations)
        steps = effect.step(steps)
    if (steps > own).any():
        truth = mean_reading(truth, steps, deviations)
    return truth, steps


# The recording of a run: manifest and streams of `mimu-recording/1`.

ENCODER_NOISE, ENCODER_STEP = 2e-7, 1e-7  # rad
SPEED_NOISE, SPEED_STEP = 1e-6, 1e-7  # rad/s
SENSOR_NOISE = 0.02  # K, of the unit's own thermometer


def recording_of(case: Case, noise_free: NoiseFree, readings: np.ndarray) -> Recording:
    """Readings (6, n) with the table's and the room's streams and the manifest."""
    channels = dict(zip(GYRO + ACCEL, readings, strict=True))
    rng = generator(case.seed, "thermometer")
    if case.temperature_recorded:
        own = weather(case, noise_free.true_time).temperature
        channels["temperature"] = _rounded(own + SENSOR_NOISE * rng.standard_normal(len(own)), 1e-3)
    return Recording(
        manifest=manifest_of(case, noise_free.plan),
        imu=Stream(noise_free.stamp, channels),
        table=_table(case, noise_free),
        environment=room_stream(case, noise_free.plan),
    )


def manifest_of(case: Case, plan: Plan) -> Manifest:
    """What the bench's program would write: it knows no effect."""
    axes = zip(plan.table.names, plan.table.directions, strict=True)
    segments = [
        {
            "name": planned.name,
            "kind": planned.kind,
            "t_start": start,
            "t_end": end,
            **planned.label,
        }
        for planned, start, end in zip(plan.segments, plan.bounds, plan.bounds[1:], strict=False)
    ]
    if len(set(plan.mounts)) > 1:
        for segment, planned in zip(segments, plan.segments, strict=True):
            segment["mount"] = {"quaternion_wxyz": plan.mounts[planned.fixing]}
    return Manifest.model_validate({
        "format": "mimu-recording/1",
        "recording_id": f"plant_{case.procedure}_{case.seed}",
        "standard": plan.standard,
        "unit": {
            "manufacturer": "Plant", "model": f"M-{case.grade}", "serial": f"SN{case.seed:05d}"
        },
        "station": {
            "id": "PLANT",
            "latitude_deg": case.latitude_deg if case.site_known else None,
            "gravity_m_s2": case.gravity_m_s2,
            "heading_deg": case.heading_deg if case.site_known else None,
            "table_axes": [{"name": name, "direction": where} for name, where in axes],
        },
        "mount": {"quaternion_wxyz": plan.mounts[0]},
        "streams": {name: f"{name}.parquet" for name in ("imu", "table", "environment")},
        "segments": segments,
    })  # fmt: skip


def _table(case: Case, noise_free: NoiseFree) -> Stream:
    rng = generator(case.seed, "encoder")
    columns = {}
    streams = zip(
        noise_free.plan.table.names, noise_free.table_angles, noise_free.table_rates, strict=True
    )
    for name, angle, rate in streams:
        jitter = ENCODER_NOISE * rng.standard_normal(len(angle))
        columns[f"{name}_angle"] = _rounded(angle + jitter, ENCODER_STEP)
        jitter = SPEED_NOISE * rng.standard_normal(len(rate))
        columns[f"{name}_rate"] = _rounded(rate + jitter, SPEED_STEP)
    return Stream(noise_free.table_t, columns)


def room_stream(case: Case, plan: Plan) -> Stream:
    """Air temperature, humidity, supply and pressure, once a second."""
    t = np.arange(0.0, np.floor(plan.duration))
    room = weather(case, t)
    return Stream(t, {
        "temperature": _rounded(room.air, 0.01),
        "humidity": _rounded(room.humidity, 0.01),
        "supply_voltage": _rounded(room.supply, 1e-4),
        "pressure": _rounded(room.pressure, 0.01),
    })  # fmt: skip


def _rounded(values: np.ndarray, step: float) -> np.ndarray:
    return np.asarray(np.round(values / step) * step)


@dataclass(frozen=True)
class Simulated:
    """recording: what is handed out. The rest is sealed.

    truth, nominal: (n, 6), one row for each row of the unit's stream; see `Heard` for what is in
    them. reported: (n, 6), rates rad/s and specific force m/s² that the table reports. sealed:
    truth.json: grade, parameters of unit and effects in SI, and units.
    """

    case: Case
    recording: Recording
    truth: np.ndarray
    nominal: np.ndarray
    reported: np.ndarray
    sealed: dict[str, Any]


def simulate(case: Case) -> Simulated:
    """Plays a case with noise, limits and rounding. Raises ValueError for an impossible case."""
    return simulated_from(case, without_noise(case))


def simulated_from(case: Case, noise_free: NoiseFree) -> Simulated:
    """The recording of a case whose readings without noise are known."""
    readings = noise_free.analog + noise_free.shaken + sensor_noise(case, noise_free.truth.shape[1])
    for effect in noise_free.effects:
        if (limits := effect.limits()) is not None:
            readings = np.clip(readings, -limits[:, None], limits[:, None])
    steps = noise_free.steps[:, None]
    readings = np.round(readings / steps) * steps
    return Simulated(
        case,
        recording_of(case, noise_free, readings),
        noise_free.truth.T,
        noise_free.nominal.T,
        noise_free.reported.T,
        sealed_of(case, noise_free),
    )


def sealed_of(case: Case, noise_free: NoiseFree) -> dict[str, Any]:
    """The truth as plain data: every parameter in SI with its unit."""
    return {
        "case": case.model_dump(mode="json"),
        "effects": {effect.name: dict(effect.parameters) for effect in noise_free.effects},
        "units": {effect.name: dict(effect.units) for effect in noise_free.effects},
        "grade": case.grade,
        "parameters": noise_free.unit.parameters(),
    }


def sensor_noise(case: Case, count: int) -> np.ndarray:
    """(6, n): every channel its own, the same whatever the effects."""
    return np.stack([
        noise(generator(case.seed, f"noise {channel}"), model, count, case.rate_hz)
        for channel, model in enumerate(channel_noise(case.grade))
    ])  # fmt: skip


# A simulated recording as files: what is handed out, and apart from it what is sealed.


def write(recording: Recording, folder: Path) -> None:
    """Writes manifest.json and the streams; nothing of the truth."""
    folder.mkdir(parents=True, exist_ok=True)
    streams = recording.streams()
    files = {name: f"{name}.parquet" for name in streams}
    manifest = recording.manifest.model_copy(update={"streams": files})
    _write_json(manifest.model_dump(mode="json", exclude_none=True), folder / "manifest.json")
    for name, stream in streams.items():
        pd.DataFrame({"t": stream.t, **stream.columns}).to_parquet(
            folder / files[name], index=False
        )


def seal(recording: Recording, declared: dict[str, Any], truth: np.ndarray, folder: Path) -> None:
    """Writes truth.json and truth.parquet to another place.

    declared: what truth.json says. truth: (n, 6), the noise-free channels at the recording's rows.
    """
    folder.mkdir(parents=True, exist_ok=True)
    _write_json(declared, folder / "truth.json")
    columns = {"t": recording.imu.t}
    columns |= dict(zip(GYRO + ACCEL, truth.T, strict=True))
    pd.DataFrame(columns).to_parquet(folder / "truth.parquet", index=False)


def _write_json(response: object, path: Path) -> None:
    path.write_text(json.dumps(response, indent=1, ensure_ascii=False), encoding="utf-8")


# How visible an effect is: its signal beside the noise, after the standard's model took its part.
#
# z² = Σ over channels of the squared norm of what the best fit of the standard's columns leaves,
# weighed by the inverse of the true noise spectrum. z is the limit of any detector that knows the
# effect's form: its statistic has mean z and deviation 1.

CLOSE = 0.02  # relative, of z asked for
UNSEEN = 1e-3  # z below which there is nothing to see
STEPS = 10  # steps at most
LARGEST = 100.0  # strength that still makes sense
REACH = 30.0  # how much the strength may change in one step


class Visibility(NamedTuple):
    """z, and concealment: the share of the effect's power that the standard's columns absorb."""

    z: float
    concealment: float


def visibility(simulated: Simulated, effect: str) -> Visibility:
    """The visibility of one effect of a simulated case, beside its other effects."""
    return _Judge(simulated.case, effect).of(simulated.truth - simulated.nominal)


def visibility_of(case: Case, effect: str) -> Visibility:
    """The same from the case alone, without making the noise."""
    return _Judge(case, effect).of(_excess(without_noise(case)))


def visibility_beside(case: Case, added: np.ndarray) -> Visibility:
    """The visibility of readings (n, 6) that are added to those of a case."""
    judge = _Judge(case, "")
    return judge.of(judge.rest + added)


def at_visibility(case: Case, effect: str, z: float) -> Case:
    """The case with the strength of one effect set so that its visibility is z, within 2 %.

    Effects that come in whole numbers or start at a threshold get as near as they can. The Earth
    turns as it does: earth_rotation stays as it is. Raises ValueError for an effect that the
    standard's model absorbs whole in this procedure, or so much of it that it would have to be
    absurdly large.
    """
    if effect == "earth_rotation":
        return case
    judge = _Judge(case, effect)
    strength = next(call.strength for call in case.effects if call.name == effect) or 1.0
    tried: list[tuple[float, float]] = []
    while len(tried) < STEPS:
        reached = judge.of(_excess(without_noise(case.with_strength(effect, strength)))).z
        if not tried and reached < UNSEEN:
            raise ValueError(f"{effect} cannot be seen in this procedure: the standard absorbs it")
        stuck = bool(tried) and tried[-1][1] == reached > z  # nothing smaller is to be had
        tried.append((strength, max(reached, UNSEEN)))
        if stuck or abs(reached / z - 1.0) < CLOSE:
            break
        strength = _next_strength(tried, z)
        if strength > LARGEST:
            raise ValueError(f"{effect} would need {strength:.0f} times its typical size for z {z}")
    best = min(tried, key=lambda pair: abs(np.log(pair[1] / z)))
    return case.with_strength(effect, best[0])


def _next_strength(tried: list[tuple[float, float]], z: float) -> float:
    """In proportion at first, then a secant step in logarithms, kept inside what brackets z."""
    strength, reached = tried[-1]
    slope = 1.0
    if len(tried) > 1:
        earlier, before = tried[-2]
        slope = float(np.clip(np.log(reached / before) / np.log(strength / earlier), 0.3, 4.0))
    wanted = strength * float(np.clip((z / reached) ** (1.0 / slope), 1.0 / REACH, REACH))
    below = max((one for one, observation in tried if observation < z), default=0.0)
    above = min((one for one, observation in tried if observation > z), default=np.inf)
    inside = below < wanted < above
    return wanted if inside or not below < above < np.inf else float(np.sqrt(below * above))


def _excess(noise_free: NoiseFree) -> np.ndarray:
    return (noise_free.truth - noise_free.nominal).T


class _Judge:
    """The rest of the case, without noise, and the standard's columns with their whitening."""

    def __init__(self, case: Case, effect: str) -> None:
        rest = without_noise(case.without(effect))
        self.rest = _excess(rest)
        rates, force = rest.reported[:3].T, rest.reported[3:].T
        one = np.ones((len(rates), 1))
        self.whitenings = [
            _Whitening(noise, len(rates), case.rate_hz)
            for noise in (GYRO_NOISE[case.grade], ACCEL_NOISE[case.grade])
        ]
        gyro = np.hstack([rates, one, force])
        self.columns = [gyro] * 3
        for axis in range(3):
            self.columns.append(np.hstack([force, one, np.delete(rates, axis, axis=1) ** 2]))

    def of(self, excess: np.ndarray) -> Visibility:
        """The visibility of what the case (n, 6) has beyond its rest; lost rows count nothing."""
        signal = np.zeros_like(self.rest)
        rows = min(len(excess), len(signal))
        signal[:rows] = excess[:rows] - self.rest[:rows]
        observation = total = left = 0.0
        for channel, series in enumerate(signal.T):
            if not series.any():
                continue
            whiten = self.whitenings[channel // 3]
            columns = _varying(self.columns[channel])
            white, known = whiten(columns.T), whiten(series)
            found, *_ = np.linalg.lstsq(white.T, known, rcond=1e-10)
            observation += float(((known - found @ white) ** 2).sum())
            total += float(series @ series)
            left += float(((series - columns @ found) ** 2).sum())
        return Visibility(
            float(np.sqrt(observation)), max(0.0, 1.0 - left / total) if total else 0.0
        )


def _varying(columns: np.ndarray) -> np.ndarray:
    """The columns at one size, without those that are nowhere (axes that never turn)."""
    size = np.sqrt((columns**2).mean(axis=0))
    return np.asarray(columns[:, size > 1e-12] / size[size > 1e-12])


class _Whitening:
    """Divides courses (…, n) by the root of the noise spectrum; ends are mirrored, not wrapped."""

    def __init__(self, noise: Noise, count: int, rate: float) -> None:
        self.count = count
        self.length = next_fast_len(2 * count, real=True)
        frequency = rfftfreq(self.length, 1.0 / rate)
        frequency[0] = frequency[1] / 2.0
        self.gain = 1.0 / np.sqrt(noise.density(frequency) * rate / 2.0)

    def __call__(self, series: np.ndarray) -> np.ndarray:
        ends = [(0, 0)] * (series.ndim - 1) + [(0, self.length - self.count)]
        mirrored = np.pad(series, ends, mode="symmetric")
        return np.asarray(irfft(rfft(mirrored) * self.gain, self.length)[..., : self.count])
