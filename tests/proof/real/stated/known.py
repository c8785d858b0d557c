"""What is known of the real recordings by their makers and by hand, beside what explain says."""

from collections.abc import Mapping
from dataclasses import dataclass, field

RIG = "maker's register map, and the phase of the gyro against the encoder, by hand"
POSES = "least squares of the readings on the poses and their derivatives, 10 to 12 Hz, by hand"
DELAYS = ("time_offset", "bandwidth")
DELAY_PARAMETERS = ("seconds", "time_constant")
CODES = "the values that occur, counted by hand"
EVERYTHING = ("*",)


@dataclass(frozen=True)
class Known:
    """One fact of a recording.

    names: of the catalogue that state it; EVERYTHING: any that no other fact is about. there:
    whether it is; None: what is known does not decide it. within: from and to, SI, of parameters
    that state its size; several of one name of DELAYS count together.
    """

    recording: str
    names: tuple[str, ...]
    there: bool | None
    fact: str
    source: str
    within: Mapping[str, tuple[float, float]] = field(default_factory=dict)


def _delay(recording: str, low: float, high: float, fact: str, source: str = RIG) -> Known:
    within = dict.fromkeys(DELAY_PARAMETERS, (low, high))
    return Known(recording, DELAYS, True, fact, source, within)


def _codes(recording: str) -> Known:
    fact = "accelerometer codes are 0.01 g apart, coarser than the noise at rest"
    return Known(recording, ("coarse_quantisation",), True, fact, CODES)


KNOWN: tuple[Known, ...] = (
    _delay(
        "encoder_mpu6050_pitch_slow", 4.8e-3, 14e-3,
        "the unit's low-pass alone is 4.8 ms late; the same rig about other axes 10 to 12 ms",
    ),
    _codes("encoder_mpu6050_pitch_slow"),
    _delay("encoder_roll_slow", 10e-3, 12e-3, "the gyro lags the encoder by 10 to 12 ms"),
    _codes("encoder_roll_slow"),
    _delay("encoder_yaw_fast", 11e-3, 13e-3, "the gyro lags the encoder by about 12 ms"),
    _codes("encoder_yaw_fast"),
    Known(
        "encoder_yaw_fast", ("axis_wobble", "axis_tilt"), False,
        "the accelerometers show no tilt that follows the angle", "their means by angle, by hand",
    ),
    Known(
        "encoder_yaw_fast", ("structural_compliance",), None,
        "the shaft between encoder and unit twists, at 10.5 Hz; a lean by rate² was not looked for",
        "swing of the unit against that of the encoder, by hand",
    ),
    Known(
        "tumvi_room4", ("reference_frame",), True,
        "tracked body and unit are turned by 0.13° against each other", POSES,
    ),
    Known(
        "tumvi_room4", EVERYTHING, False,
        "calibrated by its authors, poses in the unit's own frame and on its clock (0.08 ms); "
        "lever arm (−0.1, −1.3, 0.1) ± 1.3 mm: nothing is left out",
        "the authors' documentation, and " + POSES,
    ),
    _delay("broad_18", 4.1e-3, 4.2e-3, "the gyro lags the poses by 4.1 to 4.2 ms", POSES),
    Known(
        "broad_18", ("lever_arm",), True,
        "accelerometers at (2.8, −1.5, 7.3) mm from the tracked origin, known to some 2 mm", POSES,
        {"r_x": (1e-3, 5e-3), "r_y": (-4e-3, 1e-3), "r_z": (5e-3, 9e-3)},
    ),
    Known(
        "broad_18", ("reference_frame",), True,
        "tracked body and unit are turned by 0.1 to 0.3° against each other", POSES,
    ),
    Known(
        "ln100_two_position", ("earth_rotation",), True,
        "half the difference of up and down is 11.733 °/h, Earth's vertical part there 11.702",
        "means of both rests, by hand",
    ),
    Known(
        "ln100_two_position", EVERYTHING, False,
        "beside Earth's rotation nothing of note is in it", "means of both rests, by hand",
    ),
    Known(
        "vn200_57630_six_position", ("axis_mapping",), True,
        "x reads −9.80 m/s² where +x is said to point up and +9.78 where −x is, y −9.78 and +9.80: "
        "both against what is told, z as it is told",
        "means of the rests, by hand",
    ),
    Known(
        "adi_mems_two_position", ("earth_rotation",), False,
        "noise of 3.3e-3 °/s over a rest hides Earth's rotation", "scatter of the rests, by hand",
    ),
)  # fmt: skip
