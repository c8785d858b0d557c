"""Which recordings may leave something open: drawn from a seed, nothing chosen by hand."""

import numpy as np

from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.simulate import at_visibility, without_noise

EFFECTS = (
    "lever_arm", "size_effect", "gyro_scale_nonlinearity", "gyro_scale_asymmetry",
    "gyro_g2_sensitivity", "gyro_scale_g_dependence", "accel_nonlinearity",
    "structural_compliance", "axis_wobble", "rate_ripple", "temperature_bias",
)  # fmt: skip
DELAYS = ("time_offset", "bandwidth", "gyro_angular_acceleration")  # hardly ever told apart
OF_DELAYS = 0.05  # of all that is drawn: they stay open far oftener than the others
VISIBLE = (5.5, 30.0)  # z in the first recording, from and to
RATES_HZ = (50, 100)
RATES_DEG_S = ((30.0, 120.0), (40.0, 100.0, 200.0), (20.0, 150.0))


WITH_CHAMBER = 0.5  # of the stations


def has_chamber(seed: int, number: int) -> bool:
    """Whether the station of a case has a chamber whose temperature can be set."""
    return bool(np.random.default_rng([seed, number, 176]).uniform() < WITH_CHAMBER)


def draw(seed: int, number: int) -> tuple[Case, str]:
    """A short recording of the specification's sequence, and the effect that it has."""
    rng = np.random.default_rng([seed, number, 175])
    low, high = np.log(VISIBLE)
    while True:
        name = str(rng.choice(DELAYS if rng.uniform() < OF_DELAYS else EFFECTS))
        case = Case(
            seed=int(rng.integers(1, 1_000_000)),
            grade=str(rng.choice(["consumer", "industrial"])),  # type: ignore[arg-type]
            procedure="three_axis",
            rate_hz=int(rng.choice(RATES_HZ)),
            rates_deg_s=RATES_DEG_S[int(rng.integers(len(RATES_DEG_S)))],
            dwell_s=5.0,
            effects=(EffectCall(name=name),),
        )
        try:
            noise_free = without_noise(
                at_visibility(case, name, float(np.exp(rng.uniform(low, high))))
            )
        except ValueError:  # the procedure does not show it
            continue
        # by its parameters, so that the unit has the same in another run
        call = EffectCall(name=name, parameters=dict(noise_free.effects[0].parameters))
        return case.model_copy(update={"effects": (call,)}), name
