"""Runs of JJF 2003 on other tables than the validation's: polled, unseen, of one axis, and others.

Each draws what its budget states besides and gives the recording as such a station would.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from schemas.calibration import Method
from schemas.laboratory import EquipmentLimit, LimitName
from schemas.recording import ACCEL, GYRO, Recording, Stream
from tasks.station.virtual.config import DEGREE
from tasks.uncertainty.equipment import JJF2003, ErrorLimit
from tasks.validation import run2003
from tasks.validation.coverage import RUNS, simulate, truth_by
from tasks.validation.simulated_units import (
    Journey,
    SimulatedUnit,
    TableErrors,
    draw_simulated_unit,
    recording_of,
    sensed_rates,
)

POLLED_S, POLLS_HZ = 2e-3, 10.0  # within which a polled angle's time is known, and how often
TURNED = {  # body axes in the fixture of a table of one axis: about x, then z, degrees
    "+x": (90.0, 90.0), "-x": (90.0, -90.0), "+y": (90.0, 0.0), "-y": (90.0, 180.0),
    "+z": (0.0, 0.0), "-z": (180.0, 0.0),
}  # fmt: skip
BASE = EquipmentLimit(half_width=2e-4, distribution="rectangular", source="base, 41 arc seconds")
CLOCK = EquipmentLimit(half_width=2e-5, distribution="rectangular", source="clock, 20 ppm")
OWN: dict[LimitName, EquipmentLimit] = {"mounting": BASE, "time_base": CLOCK}

Truth = dict[str, dict[str, float]]
Made = tuple[Recording, Truth]


def by_polls(method: str, seed: int) -> Made:
    """Encoders read ten times a second, each at a time known to ±2 ms."""
    recording, truth = simulate(method, seed)
    assert recording.table is not None
    random = np.random.default_rng((seed, 9))
    t = np.arange(recording.table.t[0], recording.table.t[-1], 1.0 / POLLS_HZ)
    read = t + random.uniform(-POLLED_S, POLLED_S, len(t))
    angles = {
        name: np.interp(read, recording.table.t, values)
        for name, values in recording.table.columns.items()
    }
    stated = {"table_time": {"half_width_s": POLLED_S}}
    manifest = type(recording.manifest).model_validate(recording.manifest.model_dump() | stated)
    return replace(recording, table=Stream(t, angles), manifest=manifest), truth


def by_labels(method: str, seed: int) -> Made:
    """Nothing says how the table stood but the labels."""
    recording, truth = simulate(method, seed)
    return replace(recording, table=None), truth


@dataclass(frozen=True)
class OnItsBase(SimulatedUnit):
    """A unit whose base tilts it in the fixture, each time that it is mounted."""

    def errors(self, count: int, *limits: ErrorLimit | None) -> np.ndarray:
        drawn = super().errors(count, *limits)
        if any(limit is not None and limit.symbol == "α4" for limit in limits):
            drawn = drawn + self.random.uniform(-BASE.half_width, BASE.half_width, count)
        return drawn


def on_base_by_clock(method: str, seed: int) -> Made:
    """A base as flat as stated, and a clock as good as stated."""
    record, rate_hz = RUNS[method]
    drawn = draw_simulated_unit(seed, rate_hz)
    recording, truth = record(OnItsBase(drawn.unit, drawn.random), seed)
    fast = 1.0 + np.random.default_rng((seed, 9)).uniform(-CLOCK.half_width, CLOCK.half_width)
    segments = tuple(
        label.model_copy(update={"t_start": fast * label.t_start, "t_end": fast * label.t_end})
        for label in recording.manifest.segments or ()
    )
    return (
        replace(
            recording,
            manifest=recording.manifest.model_copy(update={"segments": segments}),
            imu=replace(recording.imu, t=fast * recording.imu.t),
            table=recording.table and replace(recording.table, t=fast * recording.table.t),
        ),
        truth_by(method, truth),
    )


def on_one_axis(method: str, seed: int) -> Made:
    """A table with a vertical axis alone: the unit is mounted anew for each face."""
    simulated = draw_simulated_unit(seed, run2003.RATE_HZ)
    errors = TableErrors(
        rate=simulated.error(*JJF2003.rate_at(run2003.RATES[0] * DEGREE)),
        ripple=simulated.error(JJF2003.ripple),
        phase=simulated.random.uniform(0.0, 2.0 * np.pi),
        level=tuple(simulated.errors(2, JJF2003.level)),
    )
    site = simulated.site(JJF2003.gravity, JJF2003.latitude)
    journey = _journey_on_one_axis(simulated)
    track = journey.track()
    read = sensed_rates(track, errors, site, simulated.unit, simulated.noise())
    imu = dict(zip(GYRO + ACCEL, read, strict=True))
    outer = Stream(np.arange(len(read[0])) / run2003.RATE_HZ, {"outer_angle": track[0, ::2]})
    recording = recording_of("JJF 2003-2022", seed, journey, imu)
    axis = {"name": "outer", "direction": [0.0, 0.0, 1.0]}
    fields = recording.manifest.model_dump()
    fields["station"] |= {"table_axes": [axis]}
    manifest = type(recording.manifest).model_validate(fields)
    truth = truth_by(method, run2003.truth(simulated, site))
    return replace(recording, manifest=manifest, table=outer), truth


def _journey_on_one_axis(simulated: SimulatedUnit) -> Journey:
    """The twelve positions and the rates of each axis, face by face."""
    journey = Journey(run2003.RATE_HZ)
    at: dict[float, float] = {}
    for up, (about_x, about_z) in TURNED.items():
        mounted = simulated.errors(3, JJF2003.fixture)
        mount = {"mount": {"quaternion_wxyz": _quaternion(about_x, about_z)}}
        for turn in (0.0, 180.0):
            at.setdefault(turn, simulated.error(JJF2003.position))
            set_to = at[turn] + simulated.error(JJF2003.repeatability)
            outer, x, z = (angle * DEGREE for angle in (turn, about_x, about_z))
            journey.place(outer, x, z, mounted, np.array([set_to, 0.0, 0.0]))
            journey.stay(run2003.DWELL_S, {
                "name": f"position_{up}_{turn:03.0f}", "kind": "static", "up": up,
                "item": "twelve_position", "turn_deg": turn, **mount,
            })  # fmt: skip
        if up[0] == "-":
            continue
        rest = {"kind": "static", "item": "rate_sensitivity", "up": up, **mount}
        journey.stay(run2003.DWELL_S, {"name": f"rest_before_{up[1]}", **rest})
        for rate in run2003.RATES:
            journey.change_rate(rate * DEGREE)
            journey.stay(run2003.DWELL_S, {
                "name": f"rate_{up[1]}_{rate:+.0f}", "kind": "rate", "item": "scale_factor",
                "axis": up[1], "up": up, "rate_deg_s": rate, **mount,
            })  # fmt: skip
        journey.change_rate(0.0)
        journey.stay(run2003.DWELL_S, {"name": f"rest_after_{up[1]}", **rest})
    return journey


def _quaternion(about_x: float, about_z: float) -> list[float]:
    """(w, x, y, z) of a turn about x, then about the new z, degrees."""
    x, z = 0.5 * np.radians(about_x), 0.5 * np.radians(about_z)
    return [
        float(np.cos(x) * np.cos(z)), float(np.sin(x) * np.cos(z)),
        float(-np.sin(x) * np.sin(z)), float(np.cos(x) * np.sin(z)),
    ]  # fmt: skip


OTHERS: dict[str, tuple[tuple[Method, ...], Callable[[str, int], Made], dict]] = {
    "polled encoders": (("jjf2003", "joint"), by_polls, {}),
    "labels only": (("jjf2003", "joint"), by_labels, {}),
    "one axis": (("jjf2003", "joint"), on_one_axis, {}),
    "base and time base drawn": (("jjf2003", "joint", "jjf1536"), on_base_by_clock, OWN),
}
