"""Recordings of a unit that follows one law of an unlisted form, at a given visibility."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from schemas.recording import Recording
from tests.proof.plant.case import Case
from tests.proof.plant.noise_free_case import drive, motions_of, sampled, without_noise
from tests.proof.plant.procedures import plan_of
from tests.proof.plant.seeds import generator
from tests.proof.plant.simulate import simulated_from
from tests.proof.plant.unlisted import curves, memory, thermal, vibration
from tests.proof.plant.unlisted.law import Law
from tests.proof.plant.visibility import visibility_beside
from tests.proof.plant.world import Setting, World

LAWS: dict[str, Law] = {
    law.name: law
    for module in (memory, curves, vibration, thermal)
    for law in module.LAWS
}  # fmt: skip
IN_BAND = 0.01  # of the vibration: the rest lies above the unit's band


def case_of(law: Law, seed: int) -> Case:
    """The run that can show a law: every axis turns; the room's temperature goes to and fro."""
    rng = generator(seed, f"case {law.name}")
    thermal_law = law.behaviour == "late temperature"
    return Case(
        seed=seed,
        grade=str(rng.choice(["consumer", "industrial", "tactical"])),  # type: ignore[arg-type]
        procedure="three_axis",
        rate_hz=50,
        rates_deg_s=((20.0, 60.0, 150.0, 250.0), (10.0, 50.0, 100.0, 200.0, 300.0))[
            int(rng.integers(2))
        ],
        dwell_s=20.0 if thermal_law else 12.0,
        order=str(rng.choice(["rising", "alternating", "shuffled"])),  # type: ignore[arg-type]
        climate="cycling" if thermal_law else "room",
        latitude_deg=round(float(rng.uniform(-50.0, 60.0)), 2),
        heading_deg=round(float(rng.uniform(-180.0, 180.0)), 1),
        gravity_m_s2=round(float(rng.uniform(9.781, 9.825)), 4),
    )


def recordings(law: Law, case: Case, z: tuple[float, ...]) -> Iterator[Recording]:
    """The same run, unit and noise with the law at each visibility; z 0 is without it."""
    clean = without_noise(case)
    setting = Setting(case, clean.plan)
    motion, _ = motions_of(setting, (), *drive(case, plan_of(case)))
    world = World(setting, motion)
    part = sampled(law.sense(world), motion, (), clean.true_time, np.empty(0, int))
    unit = visibility_beside(case, part.T).z
    shaken = np.zeros_like(part)
    if law.vibration is not None:
        noise = generator(case.seed, f"shaking {law.name}").standard_normal((3, len(world.t)))
        shaking = np.concatenate([np.zeros_like(noise), IN_BAND * law.vibration(world) * noise])
        shaken = sampled(shaking, motion, (), clean.true_time, np.empty(0, int))
    for each in z:
        grown = each / unit * part
        made = replace(
            clean, analog=clean.analog + grown, truth=clean.truth + grown,
            shaken=shaken if each else np.zeros_like(part),
        )  # fmt: skip
        yield simulated_from(case, made).recording
