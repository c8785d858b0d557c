"""Strong effects outside the catalogue: what rigs, cables and ageing electronics do."""

from typing import ClassVar

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from tests.proof.plant.effects.base import Effect, Parameters, unit_vector
from tests.proof.plant.effects.memory import in_one_direction
from tests.proof.plant.noise_free_case import fine_rate
from tests.proof.plant.seeds import generator
from tests.proof.plant.world import Setting, World


class RigMode(Effect):
    """The shaft between encoder and unit is not stiff: a second-order transfer of the angle.

    J·θ̈ + d·(θ̇ − motoṙ) + k·(θ − motor) = 0: H = (1 + 2ζjr) / (1 + 2ζjr − r²), r = f/f₀. Strength
    softens the rig: f₀ falls with its root.
    """

    name = form = "x_rig_mode"
    units: ClassVar = {"frequency": "Hz", "damping": "1"}
    sized = ()

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "frequency": float(rng.uniform(7.0, 16.0)),
            "damping": float(rng.uniform(0.02, 0.1)),
        }

    @classmethod
    def at(cls, typical: Parameters, strength: float) -> Parameters:
        softer = typical["frequency"] / float(np.sqrt(max(strength, 1e-6)))
        return typical | {"frequency": max(softer, 2.0)}

    def shaft(self, motor: np.ndarray) -> np.ndarray:
        length = next_fast_len(2 * motor.shape[1], real=True)
        ratio = rfftfreq(length, 1.0 / fine_rate(self.setting.case)) / self.parameters["frequency"]
        lossy = 1.0 + 2j * self.parameters["damping"] * ratio
        transfer = lossy / (lossy - ratio**2)
        moved = motor.copy()
        line = np.linspace(motor[0, 0], motor[0, -1], motor.shape[1])  # ends alike: no wrap-around
        swung = irfft(rfft(motor[0] - line, length) * transfer, length)[: motor.shape[1]]
        moved[0] = line + swung
        return moved


class Backlash(Effect):
    """A gear between encoder and unit has play: the unit follows when the flank is reached."""

    name = form = "x_backlash"
    units: ClassVar = {"half": "rad"}
    sized = ("half",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"half": 2e-3}

    def shaft(self, motor: np.ndarray) -> np.ndarray:
        moved, last, half = motor.copy(), float(motor[0, 0]), self.parameters["half"]
        for low, high, sign in in_one_direction(np.diff(motor[0], prepend=motor[0, 0]) * 1e3):
            reach = motor[0, low:high] - sign * half
            if sign > 0.0:
                moved[0, low:high] = np.maximum(last, reach)
            elif sign < 0.0:
                moved[0, low:high] = np.minimum(last, reach)
            else:
                moved[0, low:high] = last
            last = float(moved[0, high - 1])
        return moved


class StickSlip(Effect):
    """Friction that comes and goes: in random stretches the unit sticks, then jumps after."""

    name = form = "x_stick_slip"
    units: ClassVar = {"jump": "rad", "share": "1"}
    sized = ("jump",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"jump": 5e-3, "share": float(rng.uniform(0.2, 0.5))}

    def shaft(self, motor: np.ndarray) -> np.ndarray:
        rng = generator(self.setting.case.seed, "stick slip")
        moved, jump, place = motor.copy(), self.parameters["jump"], motor[0]
        tooth = np.floor(place / jump)
        # a smooth stair: sticks for most of a tooth and catches up at its end
        stair = jump * (tooth + (place / jump - tooth) ** 4)
        count = motor.shape[1]
        times = np.sort(rng.uniform(0.0, count, 2 * max(int(self.setting.plan.duration / 8.0), 2)))
        rough = np.interp(np.arange(count), times, rng.uniform(size=len(times)))
        weight = np.clip((self.parameters["share"] - rough) / 0.05, 0.0, 1.0)
        moved[0] = place + weight * (stair - place)
        return moved


class GainDrift(Effect):
    """The scale factors wander in minutes, whatever the temperature: a path of its own for each
    channel, made of three slow waves."""

    name = form = "x_gain_drift"
    units: ClassVar = {"gain": "1"}
    sized = ("gain",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"gain": (2e-3 * rng.uniform(0.3, 1.5, 6)).tolist()}

    def sense(self, world: World) -> np.ndarray:
        rng = generator(self.setting.case.seed, "gain drift")
        paths = np.zeros((6, len(world.t)))
        for _ in range(3):
            period, phase = rng.uniform(25.0, 160.0, 6), rng.uniform(0.0, 2.0 * np.pi, 6)
            paths += np.sin(2.0 * np.pi * world.t / period[:, None] + phase[:, None])
        sensed = np.concatenate([world.sensed_rates(), world.sensed_force()])
        return self.value("gain")[:, None] * paths * sensed


class LooseBoard(Effect):
    """The board sits loose: it tips over by a small angle when gravity pulls it the other way."""

    name = form = "x_loose_board"
    units: ClassVar = {"vector": "rad", "along": "1"}
    sized = ("vector",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"vector": (3e-3 * unit_vector(rng)).tolist(), "along": unit_vector(rng).tolist()}

    def sense(self, world: World) -> np.ndarray:
        side = np.tanh(world.motion.force.T @ self.value("along") / 1.0)
        tip = self.column("vector") * side
        turned = [-np.cross(tip, each, axis=0) for each in (world.motion.rates, world.motion.force)]
        return np.concatenate(turned)


class RubberMount(Effect):
    """The unit sits on rubber: a mode that each change of the specific force excites.

    Accelerometers read H(f)·force, H a resonance on rubber: 1/(1 + 2jζr − r²).
    """

    name = form = "x_rubber_mount"
    units: ClassVar = {"frequency": "Hz", "damping": "1", "share": "1"}
    sized = ("share",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        frequency, damping = float(rng.uniform(6.0, 14.0)), float(rng.uniform(0.03, 0.15))
        return {"frequency": frequency, "damping": damping, "share": 0.1}

    def sense(self, world: World) -> np.ndarray:
        force = world.motion.force
        length = next_fast_len(2 * force.shape[1], real=True)
        ratio = rfftfreq(length, world.motion.step) / self.parameters["frequency"]
        excess = 1.0 / (1.0 + 2j * self.parameters["damping"] * ratio - ratio**2) - 1.0
        mirrored = np.pad(force, [(0, 0), (0, length - force.shape[1])], mode="symmetric")
        swung = irfft(rfft(mirrored) * excess, length)[:, : force.shape[1]]
        return np.concatenate([np.zeros_like(force), self.parameters["share"] * swung])


class DriveLeak(Effect):
    """One gyro hears another's drive: it reads share · |ω| · sin(8 ω/ω_top) of that rate."""

    name = form = "x_drive_leak"
    units: ClassVar = {"share": "1", "heard": "1", "hears": "1", "top_rate": "rad/s"}
    sized = ("share",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        source, hears = rng.choice(3, 2, replace=False)
        return {"share": 5e-3, "heard": int(source), "hears": int(hears),
                "top_rate": setting.top_rate}  # fmt: skip

    def sense(self, world: World) -> np.ndarray:
        source = world.sensed_rates()[self.parameters["heard"]]
        read = np.zeros((6, len(source)))
        top = self.parameters["top_rate"]
        read[self.parameters["hears"]] = self.parameters["share"] * np.abs(source) * np.sin(
            8.0 * source / top
        )  # fmt: skip
        return read
