"""One case without noise: what the unit would have read, and what the standard's model says."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tests.proof.plant.case import Case
from tests.proof.plant.effects import effects_of
from tests.proof.plant.effects.base import Effect
from tests.proof.plant.grades import channel_noise
from tests.proof.plant.motion import MARGIN, move
from tests.proof.plant.plan import Plan
from tests.proof.plant.procedures import plan_of
from tests.proof.plant.rotations import slope
from tests.proof.plant.sampling import at_times, filtered, mean_limited, mean_reading
from tests.proof.plant.unit import UnitErrors
from tests.proof.plant.world import Motion, Setting, World

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
