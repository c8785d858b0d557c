"""Which rough recordings a trial has: drawn from its seed, nothing chosen by hand."""

from collections.abc import Iterator
from typing import Any, Literal

import numpy as np

from tests.proof.plant.case import Case, Data, EffectCall
from tests.proof.plant.rough.case import Encoder, RoughCase, Run, Tracking
from tests.proof.plant.rough.effects import FORMS

Kind = Literal["control", "listed", "form", "logger", "outside", "mixed"]
Ask = tuple[Kind, tuple[str, ...], Run | None]

STANDINGS = (40.0, 100.0, 300.0)  # z asked of a listed effect, above everything else
OUTSIDE_STANDINGS = (100.0, 300.0)  # of each of several outside the catalogue
DEGREE = float(np.pi / 180.0)
RUNS: tuple[Run, ...] = ("hand", "shaft", "table")

ANYWHERE = (
    "gyro_scale_nonlinearity", "gyro_scale_asymmetry", "gyro_g2_sensitivity",
    "gyro_scale_g_dependence", "gyro_angular_acceleration", "accel_nonlinearity",
    "temperature_bias", "temperature_scale", "thermal_transient", "thermal_gradient", "bandwidth",
    "coarse_quantisation", "mains_pickup", "hysteresis", "bias_step", "bias_random_walk",
    "accel_axis_skew", "clock_skew", "dropped_samples",
)  # fmt: skip
TURNED = ("time_offset", "lever_arm", "axis_tilt", "structural_compliance", "table_scale")
ON_TABLE = (
    "size_effect", "encoder_eccentricity", "gyro_saturation", "accel_saturation",
    "magnetic_sensitivity", "supply_sensitivity", "vibration_rectification",
)  # fmt: skip
LOGGER = tuple(
    form for form in FORMS
    if form.startswith(("range", "axis", "dead", "code", "repeated", "timestamp"))
)  # fmt: skip
OTHER_FORMS = tuple(form for form in FORMS if form not in LOGGER and not form.startswith("x_"))
OUTSIDE = (
    "x_gain_drift", "x_loose_board", "x_rubber_mount", "x_drive_leak", "x_rate_product",
    "x_accel_cross_quadratic", "x_beat_line", "x_telegraph", "x_bursts", "x_rate_heating",
)  # fmt: skip
OUTSIDE_TURNED = ("x_backlash", "x_stick_slip", "x_cable_drag", "x_third_harmonic")
OUTSIDE_OF: dict[Run, tuple[str, ...]] = {
    "hand": OUTSIDE,
    "shaft": (*OUTSIDE, *OUTSIDE_TURNED, "x_rig_mode"),
    "table": (*OUTSIDE, *OUTSIDE_TURNED, "x_stress_relaxation"),
}
NEEDS_THERMOMETER = (
    "temperature_bias", "temperature_scale", "thermal_gradient", "temperature_bias_late"
)  # fmt: skip


class RoughDrawn(Data):
    """A rough case as drawn. z: asked of each listed effect, above everything else."""

    number: int
    kind: Kind
    rough: RoughCase
    z: float

    @property
    def label(self) -> str:
        """“0007”, the name of its folders: it tells nothing."""
        return f"{self.number:04d}"


def draw_rough(seed: int, short: bool = False) -> list[RoughDrawn]:
    """The cases of a rough trial, in an order that tells nothing."""
    rng = np.random.default_rng([seed, 12])
    asked = list(_short(rng) if short else _full())
    order = rng.permutation(len(asked))
    return [
        RoughDrawn(
            number=n,
            kind=asked[i][0],
            rough=rough_conditions(rng, asked[i]),
            z=float(rng.choice(STANDINGS)),
        )
        for n, i in enumerate(order, start=1)
    ]


def _full() -> Iterator[Ask]:
    for run in RUNS:
        yield from (("control", (), run) for _ in range(14))
        yield from (("outside", (), run) for _ in range(12))
    for name in (*ANYWHERE, *TURNED, *ON_TABLE):
        yield "listed", (name,), None
    for name in OTHER_FORMS:
        yield from (("form", (name,), None) for _ in range(2))
    for name in LOGGER:
        yield from (("logger", (name,), run) for run in RUNS)
    for name in (*ANYWHERE, *LOGGER):
        yield "mixed", (name,), None


def _short(rng: np.random.Generator) -> Iterator[Ask]:
    """A few of each kind, spread over runs and effects."""
    for run in RUNS:
        yield from (("control", (), run) for _ in range(2))
        yield "outside", (), run
    spread: tuple[tuple[Kind, tuple[str, ...], int], ...] = (
        ("listed", (*ANYWHERE, *TURNED, *ON_TABLE), 5), ("form", OTHER_FORMS, 4),
        ("logger", LOGGER, 3), ("mixed", (*ANYWHERE, *LOGGER), 3),
    )  # fmt: skip
    for kind, names, count in spread:
        yield from ((kind, (str(name),), None) for name in rng.choice(names, count, replace=False))


def rough_conditions(rng: np.random.Generator, ask: Ask) -> RoughCase:
    """A case with these effects at typical size; strong ones outside the catalogue are drawn."""
    kind, listed, run = ask
    run = run or _run_for(rng, listed)
    others: tuple[str, ...] = ()
    if kind in ("outside", "mixed"):
        count = int(rng.integers(2, 4)) if kind == "outside" else int(rng.integers(1, 3))
        others = tuple(map(str, rng.choice(OUTSIDE_OF[run], count, replace=False)))
    rate = int(rng.choice([100, 200]))
    declared: dict[str, Any] = {
        "seed": int(rng.integers(1, 1_000_000)),
        "grade": str(rng.choice(["consumer", "industrial"])),
        "rate_hz": rate,
        "latitude_deg": round(float(rng.uniform(-50.0, 60.0)), 2),
        "gravity_m_s2": round(float(rng.uniform(9.781, 9.825)), 4),
        "effects": tuple(EffectCall(name=name) for name in (*others, *listed)),
        "temperature_recorded": bool(set(listed) & set(NEEDS_THERMOMETER) or rng.uniform() < 0.7),
    }
    jitter = float(rng.choice([0.0, 0.0, rng.uniform(1e-4, 1e-3)]))
    if any(name.startswith("timestamp_jitter") for name in listed):
        jitter = 0.0  # one of a kind
    if run == "hand":
        seconds = float(rng.uniform(60.0, 110.0))
        return RoughCase(
            case=Case(**declared), run=run, duration_s=seconds, stamp_jitter=jitter,
            top_rate=float(rng.uniform(3.0, 5.0)), tracking=_tracking(rng, seconds),
        )  # fmt: skip
    if run == "shaft":
        axes = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
        return RoughCase(
            case=Case(**declared), run=run, duration_s=float(rng.uniform(60.0, 150.0)),
            stamp_jitter=jitter, axis=axes[int(rng.integers(3))],
            top_rate=float(rng.uniform(1.5, 6.0)), encoder=_encoder(rng, False),
        )  # fmt: skip
    procedure = str(rng.choice(["three_axis", "six_orientations"]))
    declared |= {
        "procedure": procedure,
        "dwell_s": 5.0,
        "rates_deg_s": (float(rng.choice([60, 150])),),
    }
    return RoughCase(
        case=Case(**declared), run=run, stamp_jitter=jitter, encoder=_encoder(rng, True)
    )


def _run_for(rng: np.random.Generator, listed: tuple[str, ...]) -> Run:
    if set(listed) & set(ON_TABLE):
        return "table"
    turned = set(listed) & set(TURNED)
    return RUNS[int(rng.integers(1, 3))] if turned else RUNS[int(rng.integers(3))]


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    """Evenly drawn in the logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _encoder(rng: np.random.Generator, speeds: bool) -> Encoder:
    step = _between(rng, 0.01, 0.3) * DEGREE
    return Encoder(
        rate_hz=float(rng.choice([50, 80, 100, 125, 250])),
        step=step,
        noise=float(rng.uniform(0.1, 0.6)) * step,
        jitter=float(rng.choice([0.0, rng.uniform(1e-4, 1e-3)])),
        speeds=speeds and bool(rng.uniform() < 0.5),
    )


def _tracking(rng: np.random.Generator, seconds: float) -> Tracking:
    rate = float(rng.choice([100, 120, 240]))
    turn = _between(rng, 0.1, 3.0) * DEGREE * _direction(rng)
    tilt = float(rng.uniform(0.0, 1.0)) * DEGREE * _direction(rng)
    arm = float(rng.choice([0.0, _between(rng, 2e-3, 5e-2)])) * _direction(rng)
    starts = rng.uniform(5.0, seconds - 5.0, int(rng.integers(0, 4)))
    return Tracking(
        rate_hz=rate,
        position_noise=_between(rng, 5e-5, 5e-4),
        attitude_noise=_between(rng, 0.02, 0.2) * DEGREE,
        turn=tuple(turn.tolist()),
        tilt=(float(tilt[0]), float(tilt[1]), 0.0),
        arm=tuple(arm.tolist()),
        delay=float(rng.choice([0.0, 0.5])) / rate,
        interpolated=bool(rng.uniform() < 0.5),
        gaps=tuple((float(at), float(at + rng.uniform(0.1, 1.0))) for at in np.sort(starts)),
    )


def _direction(rng: np.random.Generator) -> np.ndarray:
    drawn = rng.standard_normal(3)
    return np.asarray(drawn / np.linalg.norm(drawn))
