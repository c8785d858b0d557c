"""The building blocks of a procedure at a station: oscillations, rates, turns, and rests in
every attitude, also heated and cooled.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, cast

import numpy as np

from schemas.base import Unusable
from schemas.laboratory import ChamberLimits
from schemas.procedure import (
    EnvironmentLimits,
    Oscillation,
    Position,
    RateRun,
    Refix,
    Sweep,
    Turns,
)
from schemas.recording import Axis, Mount, Recording, Station, Up
from schemas.station import StationFile
from tasks.motion.samples import sample_interval
from tasks.motion.table import axis_directions, payload_attitude
from tasks.motion.whole import TableAxes, whole_motion
from tasks.readings.plausibility import runs

# What a station can do: its table's axes, rates and acceleration, and its chamber.

RATE_DEG_S, ACCELERATION_DEG_S2 = 90.0, 120.0  # of a station file that states no limit
SMOOTH_S = 0.1  # over which the encoders tell an acceleration
RARE = 99.5  # percentile of what the encoders tell: above it is their noise
FAINT = 0.2  # of the largest acceleration: below it no axis changes its speed


@dataclass(frozen=True)
class Abilities:
    """A table and the unit on it.

    rates_deg_s: of each axis, outermost first. acceleration_deg_s2: of all. endless: of each axis,
    whether it turns on and on. chamber: None where its temperature cannot be set, or is not known
    to be. oscillates: whether the controller makes sinusoids. ramp_share: of the acceleration that
    ramps show: 1 where it is constant, ¾ where it comes and goes as sin².
    """

    station: Station
    mount: Mount
    rates_deg_s: tuple[float, ...]
    acceleration_deg_s2: float
    endless: tuple[bool, ...]
    chamber: ChamberLimits | None = None
    ramp_share: float = 1.0
    oscillates: bool = False

    @classmethod
    def of_station(cls, file: StationFile) -> "Abilities":
        """By the limits of a station file; of what it does not limit, what any table does."""
        names = [axis.name for axis in file.station.table_axes or ()]
        if not names:
            raise Unusable(
                f"the station file of {file.station.id} has no station.table_axes; "
                "list them, outermost first"
            )
        limits = {name: [each for _, each in file.limits.of(name)] for name in names}
        rates = tuple(
            min((one.rate_deg_s for one in limits[name] if one.rate_deg_s), default=RATE_DEG_S)
            for name in names
        )
        accelerations = [
            one.acceleration_deg_s2
            for name in names
            for one in limits[name]
            if one.acceleration_deg_s2
        ]
        endless = tuple(file.limits.is_endless(name) for name in names)
        acceleration = min(accelerations, default=ACCELERATION_DEG_S2)
        return cls(
            file.station, file.mount, rates, acceleration, endless, file.limits.chamber,
            oscillates="oscillate" in getattr(file.table, "commands", ()),
        )  # fmt: skip

    @classmethod
    def of_recording(cls, recording: Recording) -> "Abilities":
        """The abilities shown by the recording's own table; raises Unusable without encoders. No
        recording shows whether the station has a chamber.
        """
        manifest, axes = recording.manifest, whole_motion(recording).axes
        if axes is None:
            raise Unusable(
                f"{manifest.recording_id}: no table stream shows what its station can do; "
                "give the station file with --station FILE"
            )
        rates = np.nanmax(np.abs(np.degrees(axes.speeds)), axis=0)
        ramps = _ramps(recording, axes)
        shown = np.concatenate(ramps) if ramps else np.array([ACCELERATION_DEG_S2])
        acceleration = float(np.percentile(shown, RARE))
        turned = np.ptp(np.nan_to_num(np.degrees(axes.angles)), axis=0)
        endless = tuple((turned > 720.0).tolist())
        return cls(
            manifest.station, manifest.mount, tuple(np.round(rates, 1).tolist()),
            round(acceleration, 1), endless, ramp_share=_share(ramps),
        )  # fmt: skip

    def driven_as(self, recording: Recording) -> "Abilities":
        """With the ramps of a recording that its table made; as they are without encoders."""
        axes = whole_motion(recording).axes
        return self if axes is None else replace(self, ramp_share=_share(_ramps(recording, axes)))

    @property
    def axis_count(self) -> int:
        return len(self.rates_deg_s)


def _ramps(recording: Recording, axes: TableAxes) -> list[np.ndarray]:
    """(n,) deg/s² of an axis while it changes its speed, for each time that it does."""
    speeds = np.abs(np.degrees(axes.speeds))
    rows = max(1, round(SMOOTH_S / sample_interval(recording.imu.t)))
    change = np.nan_to_num(np.abs(speeds[rows:] - speeds[:-rows])) / SMOOTH_S
    changes = change > FAINT * change.max(initial=0.0)
    return [
        change[first:last, k] for k in range(change.shape[1]) for first, last in runs(changes[:, k])
    ]


def _share(ramps: Sequence[np.ndarray]) -> float:
    """Of the acceleration: ∫α²dt shows a lever arm, and share·limit·|Δω| is as large."""
    shares = [float(np.mean(ramp**2) / np.mean(ramp) / ramp.max()) for ramp in ramps]
    return float(np.median(shares)) if shares else 1.0


Step = Position | Sweep | RateRun | Turns | Oscillation

ITEM = "decide"
QUARTERS = (0.0, 90.0, -90.0, 180.0)  # deg
EIGHTHS = (0.0, 45.0, -45.0, 90.0, -90.0, 135.0, -135.0, 180.0)
ALONG = 0.999  # cosine from which a body axis counts as up
BISECTOR = 0.7  # and from which two of them do, alike
ASLANT = (1.0, 0.02)  # of the largest rate: the fast one is compared with the slow one
SWINGS, EACH_SLOWER = 16, 0.02  # no two rates alike, so that each segment has a name of its own
SWING_S, RATE_S, REST_S, TUMBLE_S, SOAK_S = 0.2, 6.0, 10.0, 1.0, 180.0
SINE_SHARES, SINE_S, EDGE = (1.0, 0.25), 8.0, 0.99  # of the largest rate
MOST_AMPLITUDE_DEG = 60.0  # of a table whose axis may have stops
NOISE_S = 20.0  # at rest: without it `explain` does not know by how much the readings scatter
SHARES = (1.0, 0.5, 0.25, 0.1)  # of the largest rate
# |ω| and ω² differ most at rest, at the half and at the whole (Chebyshev): there |ω| − ω² − 1/8,
# with the largest rate as 1, is −1/8, 1/8 and −1/8; the half counts as much as both others.
HALVES = (1.0, 0.5, 0.02, 0.49)
HEADINGS = (0.0, 90.0, 180.0, 270.0)
ROOM = EnvironmentLimits(temperature_degc=(15.0, 25.0), humidity_percent=(20.0, 85.0))
HOT_DEGC, ROOM_DEGC = 40.0, 20.0
HEATED_S = (120.0, 420.0)  # as long it cools; a unit follows the air in minutes


@dataclass(frozen=True)
class Block:
    """Steps that stand together."""

    name: str
    steps: tuple[Step, ...]

    @property
    def moves(self) -> bool:
        """Whether the table moves between or during its steps."""
        return not stands_still(self.steps)


def stands_still(steps: Sequence[Step | Refix]) -> bool:
    """Whether they are rests at the same angles."""
    rests = [each.angles_deg for each in steps if isinstance(each, Position)]
    return len(rests) == len(steps) and len(set(rests)) == 1


@dataclass(frozen=True)
class Attitude:
    """Table angles (deg) with one of the unit's axes up."""

    up: Up
    angles_deg: tuple[float, ...]

    @property
    def axis(self) -> Axis:
        return cast(Axis, self.up[1])

    @property
    def label(self) -> str:
        return self.up.replace("+", "p").replace("-", "n")


def blocks_of(abilities: Abilities) -> tuple[Block, ...]:
    """Every block that the station can do; raises Unusable where no axis of the unit comes up."""
    reached = attitudes(abilities)
    if not reached:
        raise Unusable(
            f"at station {abilities.station.id} no axis of the unit can point up: correct its mount"
        )
    rests = tuple(
        Position(name=f"tumble_{one.label}", item=ITEM, up=one.up, axis=one.axis,
                 angles_deg=one.angles_deg, dwell_s=TUMBLE_S)
        for one in reached
    )  # fmt: skip
    found = [Block("tumble", rests)] if len(rests) > 1 else []
    first = reached[0]
    soak = Position(name="rest", item=ITEM, up=first.up, axis=first.axis,
                    angles_deg=first.angles_deg, dwell_s=SOAK_S)  # fmt: skip
    found.append(Block("rest", (soak,)))
    if abilities.chamber is not None:
        found.extend(_heated(soak, abilities.chamber))
    if _outermost_is_vertical(abilities):
        upright = {one.axis: one for one in reversed(reached)}
        for one in sorted(upright.values(), key=lambda each: each.axis):
            found.extend(_about(one, abilities))
        found.extend(_aslant(abilities))
    return tuple(found)


def noise_rest(abilities: Abilities) -> Position:
    """A rest in the first attitude that tells the unit's noise."""
    first = attitudes(abilities)[0]
    return Position(name="noise", item=ITEM, up=first.up, axis=first.axis,
                    angles_deg=first.angles_deg, dwell_s=NOISE_S)  # fmt: skip


def _heated(rest: Position, chamber: ChamberLimits) -> Iterator[Block]:
    """Heating, then cooling back to the room's temperature."""
    low, high = chamber.temperature_degc
    degc = {"heated": min(HOT_DEGC, high), "cooled": min(max(ROOM_DEGC, low), high)}
    for seconds in HEATED_S:
        steps = tuple(
            rest.model_copy(
                update={"name": f"{name}_{seconds:.0f}s", "chamber_degc": each, "dwell_s": seconds}
            )
            for name, each in degc.items()
        )
        yield Block(f"heated_{seconds:.0f}s", steps)


def attitudes(abilities: Abilities) -> list[Attitude]:
    """Of each axis up and down the first that quarter turns of the axes reach; of a vertical one
    none does.
    """
    found: dict[Up, Attitude] = {}
    outermost = (0.0,) if _outermost_is_vertical(abilities) else QUARTERS
    for angles in product(outermost, *[QUARTERS] * (abilities.axis_count - 1)):
        up = _up(abilities, angles)
        if up is not None and up not in found:
            found[up] = Attitude(up, angles)
    return [found[up] for up in sorted(found, key=lambda up: (up[1], up[0]))]


def _aslant(abilities: Abilities) -> Iterator[Block]:
    """What turns the unit about both bisectors of each two of its axes, by the outermost axis.

    About one of its axes a steady rate shows no more of where each accelerometer is than one lever
    arm explains. Of two bisectors ωᵢ² is the same and ωᵢωⱼ is not, so that neither this lever arm
    nor the standard's sensitivities to the rate make up for places that are apart.
    """
    if not abilities.endless[0]:
        return
    rates = _rounded([share * abilities.rates_deg_s[0] for share in ASLANT])
    found: dict[str, RateRun] = {}
    for inner in product(*[EIGHTHS] * (abilities.axis_count - 1)):
        vertical = upward(abilities, (0.0, *inner))
        level = int(np.abs(vertical).argmin())
        others = np.delete(vertical, level)
        if np.abs(others).min() > BISECTOR:
            name = f"aslant_{'xyz'[level]}{'+' if others.prod() > 0 else '-'}"
            found.setdefault(name, RateRun(
                name=name, item=ITEM, spin_axis=0, angles_deg=(0.0, *inner), rates_deg_s=rates,
                dwell_s=RATE_S,
            ))  # fmt: skip
    if found:
        yield Block("aslant", tuple(found[name] for name in sorted(found)))


def _up(abilities: Abilities, angles_deg: tuple[float, ...]) -> Up | None:
    vertical = upward(abilities, angles_deg)
    k = int(np.abs(vertical).argmax())
    if abs(vertical[k]) < ALONG:
        return None
    return cast(Up, ("+" if vertical[k] > 0 else "-") + "xyz"[k])


def upward(abilities: Abilities, angles_deg: tuple[float, ...]) -> np.ndarray:
    """(3,) the direction of the vertical in the unit."""
    from scipy.spatial.transform import Rotation  # late: it takes a third of a start

    mount = Rotation.from_quat(abilities.mount.quaternion_wxyz, scalar_first=True).as_matrix()
    attitude = payload_attitude(abilities.station, np.radians(angles_deg)) @ mount
    return np.asarray(attitude.T @ np.array([0.0, 0.0, 1.0]))


def _outermost_is_vertical(abilities: Abilities) -> bool:
    return abs(float(axis_directions(abilities.station)[0][2])) > ALONG


def _about(one: Attitude, abilities: Abilities) -> Iterator[Block]:
    """What turns the unit about its axis that is up, by the outermost axis."""
    most = abilities.rates_deg_s[0]
    common: dict[str, Any] = {
        "item": ITEM, "up": one.up, "axis": one.axis, "angles_deg": one.angles_deg,
    }  # fmt: skip
    spin = common | {"spin_axis": 0}
    sign = 1.0 if one.up[0] == "+" else -1.0
    yield Block(f"headings_{one.label}", (
        Sweep(name=f"heading_{one.label}", table_axis=0, stops_deg=HEADINGS, dwell_s=REST_S,
              **common),
    ))  # fmt: skip
    if abilities.oscillates:
        yield from _sinusoids(abilities, one, spin)
    if not abilities.endless[0]:
        return
    for share in (1.0, 0.25):
        top = share * most
        slower = [top * (1.0 - EACH_SLOWER * (k // 2)) for k in range(SWINGS)]
        rates = [sign * (-1.0) ** k * rate for k, rate in enumerate(slower)]
        name = f"swing_{one.label}_{top:.0f}"
        run = RateRun(name=name, rates_deg_s=_rounded(rates), dwell_s=SWING_S, **spin)
        yield Block(name, (run,))
    for name, shares in (("rates", SHARES), ("halves", HALVES)):
        rates = [sign * way * share * most for share in shares for way in (1.0, -1.0)]
        run = RateRun(
            name=f"{name}_{one.label}", rates_deg_s=_rounded(rates), dwell_s=RATE_S, **spin
        )
        yield Block(run.name, (run,))
    yield Block(
        f"turns_{one.label}",
        (Turns(name=f"turns_{one.label}", turns=2, rate_deg_s=round(0.25 * most, 1), **spin),),
    )


def _sinusoids(abilities: Abilities, one: Attitude, spin: dict[str, Any]) -> Iterator[Block]:
    """To and fro with the largest acceleration, at the largest rate or at a part of it."""
    for share in SINE_SHARES:
        rate = share * abilities.rates_deg_s[0]
        omega = abilities.acceleration_deg_s2 / rate
        frequency = round(omega / (2.0 * np.pi), 4)
        amplitude = round(EDGE * rate / (2.0 * np.pi * frequency), 3)
        cycles = max(1, round(SINE_S * frequency))
        name = f"sine_{one.label}_{frequency:.1f}hz"
        step = Oscillation(
            name=name, amplitude_deg=amplitude, frequency_hz=frequency, cycles=cycles, **spin
        )
        if amplitude <= MOST_AMPLITUDE_DEG:
            yield Block(name, (step,))


def _rounded(rates: list[float]) -> tuple[float, ...]:
    return tuple(round(rate, 1) for rate in rates)


def steps_of(blocks: Sequence[Block]) -> list[Step]:
    """Their steps in turn, those of a block that comes again with names of their own."""
    used, steps = Counter[str](), list[Step]()
    for block in blocks:
        used[block.name] += 1
        mark = f"_{used[block.name]}" if used[block.name] > 1 else ""
        steps += [step.model_copy(update={"name": f"{step.name}{mark}"}) for step in block.steps]
    return steps


def room_of(steps: Sequence[Step], room: EnvironmentLimits) -> EnvironmentLimits:
    """The room, as wide as the steps set the chamber."""
    low, high = room.temperature_degc
    set_to = [each.chamber_degc for each in steps
              if isinstance(each, Position) and each.chamber_degc is not None]  # fmt: skip
    wider = (min([low, *set_to]), max([high, *set_to]))
    return room.model_copy(update={"temperature_degc": wider})
