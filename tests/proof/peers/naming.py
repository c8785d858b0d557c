"""What a chosen regressor means, where it has one fair reading in the catalogue; else nothing.

Left out with reason: a gyro that follows its own angular acceleration (a delay, a low-pass and an
angular acceleration do), anything that follows plain time (a walk, a step and a warm-up do),
cross products of forces in an accelerometer, and what the catalogue has no name for (humidity).
"""

import re

from schemas.discrepancy import Dimension

AXES = "xyz"
OWN, OTHER = "i", "j"

GYRO = {
    "ω_i²": "gyro_scale_nonlinearity",
    "ω_i³": "gyro_scale_nonlinearity",
    "|ω_i|": "gyro_scale_asymmetry",
    "u_i²": "gyro_g2_sensitivity",
    "u_j²": "gyro_g2_sensitivity",
    "u_i·u_j": "gyro_g2_sensitivity",
    "u_j·u_j": "gyro_g2_sensitivity",
    "ω_i·u_i": "gyro_scale_g_dependence",
    "ω_i·u_j": "gyro_scale_g_dependence",
    "ω_i·T": "temperature_scale",
    "α_j": "gyro_angular_acceleration",
    "n_i": "earth_rotation",
    "n_j": "magnetic_sensitivity",
}
ACCEL = {
    "u_i²": "accel_nonlinearity",
    "u_i³": "accel_nonlinearity",
    "u_i·T": "temperature_scale",
    "ω_i·ω_j": "lever_arm",
    "α_j": "lever_arm",
    "vibration": "vibration_rectification",
}
EITHER = {
    "T": "temperature_bias",
    "Ṫ": "thermal_gradient",
    "V": "supply_sensitivity",
    **{f"exp(-t/{tau})": "thermal_transient" for tau in (60, 300, 900)},
}

FOLLOWED: dict[str, Dimension] = {
    "T|Ṫ": "temperature",
    "α": "ramps",
    "ω": "rate",
    "V|H|p|vibration": "recorded",
    "u|n": "attitude",
}


def reading_of(channel: int, regressor: str) -> str | None:
    """The catalogue name that a regressor in a channel (0 to 5) stands for; None: no fair one."""
    own = AXES[channel % 3]
    form = re.sub(r"_([xyz])", lambda m: f"_{OWN if m[1] == own else OTHER}", regressor)
    ordered = [form, "·".join(reversed(form.split("·")))]
    table = EITHER | (GYRO if channel < 3 else ACCEL)
    return next((table[one] for one in ordered if one in table), None)


def dimension_of(regressor: str) -> Dimension:
    """What of the run a regressor follows."""
    for letters, dimension in FOLLOWED.items():
        if any(re.match(rf"\|?({letters})(_|²|³|\||$)", part) for part in regressor.split("·")):
            return dimension
    return "time"
