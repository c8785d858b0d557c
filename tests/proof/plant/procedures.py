"""The procedures: JJF 2003-2022 on three axes and on one, parts of it, and JJF 1536-2015."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from schemas.procedure import Procedure
from tests.proof.plant.case import Case
from tests.proof.plant.given import plan_of_procedure
from tests.proof.plant.plan import Plan, TableShape
from tests.proof.plant.rotations import about, product
from tests.proof.plant.seeds import generator
from tests.proof.plant.segments import Segment

ACCELERATION = 120.0  # of the table, °/s²
MOVE = 4.0  # s
TURNS = 45.0  # s for ten turns of JJF 1536
UPS = ("+x", "-x", "+y", "-y", "+z", "-z")
# middle and inner angle, in quarter turns, that bring a body axis up (outer z, middle x, inner z)
QUARTERS = {"+x": (1, 1), "-x": (1, 3), "+y": (1, 0), "-y": (1, 2), "+z": (0, 0), "-z": (2, 0)}
THREE = TableShape(("outer", "middle", "inner"), ((0, 0, 1), (1, 0, 0), (0, 0, 1)))
SINGLE = TableShape(("table",), ((0, 0, 1),))


def plan_of(case: Case) -> Plan:
    """The plan of a case's procedure."""
    match case.procedure:
        case "single_axis":
            return _single_axis(case)
        case "ahrs":
            return _ahrs(case)
        case "given":
            return plan_of_procedure(Procedure.model_validate(case.given), THREE)
        case "rests":
            blocks = [_positions(case)]
        case "one_axis":
            blocks = [_rate_block(case, "+x")]
        case "six_orientations":
            blocks = [_rate_block(case, up) for up in UPS]
        case _:
            blocks = [_positions(case), *(_rate_block(case, up) for up in ("+x", "+y", "+z"))]
    segments = [Segment("warm", "settle", 10.0, 0, {})]
    for fixing, block in enumerate(blocks):
        segments += [replace(segment, fixing=fixing) for segment in block]
    straight = (1.0, 0.0, 0.0, 0.0)
    return Plan("JJF 2003-2022", THREE, _numbered(segments), (straight,) * len(blocks))


def _numbered(segments: list[Segment]) -> tuple[Segment, ...]:
    """Moves and ramps get the number of their place, as a sequence program would name them."""
    return tuple(
        replace(segment, name=f"{segment.name}{number:03d}")
        if segment.name in ("move", "ramp")
        else segment
        for number, segment in enumerate(segments)
    )


def _attitude(up: str, turn_deg: float = 0.0) -> tuple[float, float, float]:
    middle, inner = QUARTERS[up]
    return float(np.radians(turn_deg)), middle * np.pi / 2, inner * np.pi / 2


def _positions(case: Case) -> Iterator[Segment]:
    for up in UPS:
        for turn in (0, 180):
            yield Segment("move", "transition", MOVE, 0, {}, goto=_attitude(up, turn))
            label = {"item": "twelve_position", "up": up, "turn_deg": turn}
            yield Segment(f"position_{up}_{turn:03d}", "static", case.dwell_s, 0, label)


def _rate_block(case: Case, up: str) -> Iterator[Segment]:
    yield Segment("move", "transition", MOVE, 0, {}, goto=_attitude(up))
    yield from _rates(case, up)


def _rates(case: Case, up: str) -> Iterator[Segment]:
    """A rest, each rate with its ramps from and to rest, and a rest again."""
    name = up[1] if up[0] == "+" else f"{up[1]}_down"
    rest = {"item": "rate_sensitivity", "up": up}
    yield Segment(f"rest_{name}", "static", case.dwell_s, 0, rest)
    for rate in _ordered(case, up):
        yield from _one_rate(case.dwell_s, rate, up, f"rate_{name}_{rate:+.0f}")
    yield Segment(f"rest2_{name}", "static", case.dwell_s, 0, rest)


def _one_rate(dwell: float, rate: float, up: str, name: str) -> Iterator[Segment]:
    """`rate` is what the body's axis turns at, in °/s; with the axis down the table turns back."""
    table_rate = float(np.radians(rate)) * (1.0 if up[0] == "+" else -1.0)
    ramp = abs(rate) / ACCELERATION
    yield Segment("ramp", "transition", ramp, 0, {}, ramp=(0.0, table_rate))
    label = {"item": "scale_factor", "axis": up[1], "up": up, "rate_deg_s": rate}
    yield Segment(name, "rate", dwell, 0, label, ramp=(table_rate, table_rate))
    yield Segment("ramp", "transition", ramp, 0, {}, ramp=(table_rate, 0.0))


def _ordered(case: Case, up: str) -> list[float]:
    magnitudes = sorted(case.rates_deg_s)
    if case.order == "alternating":
        return [sign * rate for rate in magnitudes for sign in (1.0, -1.0)]
    rising = [-rate for rate in reversed(magnitudes)] + magnitudes
    if case.order == "shuffled":
        generator(case.seed, f"order {up}").shuffle(rising)
    return rising


def _mount(up: str, turn_deg: float = 0.0) -> tuple[float, float, float, float]:
    """The mounting that brings a body axis up on a table with one vertical axis."""
    turn, middle, inner = _attitude(up, turn_deg)
    z, x = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    w, i, j, k = product(product(about(z, turn), about(x, middle)), about(z, inner))[:, 0]
    return float(w), float(i), float(j), float(k)


def _single_axis(case: Case) -> Plan:
    """Six mountings by hand; in each two positions half a turn apart, upright ones the rates."""
    segments: list[Segment] = []
    for fixing, up in enumerate(UPS):
        block = [Segment(f"fixed_{up}", "settle", 10.0, fixing, {})]
        for turn in (0, 180):
            heading = (float(np.radians(turn)),)
            block.append(Segment("move", "transition", MOVE, fixing, {}, goto=heading))
            label = {"item": "twelve_position", "up": up, "turn_deg": turn}
            block.append(
                Segment(f"position_{up}_{turn:03d}", "static", case.dwell_s, fixing, label)
            )
        block.append(Segment("move", "transition", MOVE, fixing, {}, goto=(0.0,)))
        if up[0] == "+":
            block += _rates(case, up)
        block.append(Segment(f"unfix_{up}", "settle", 5.0, fixing, {}))
        segments += [replace(segment, fixing=fixing) for segment in block]
    return Plan("JJF 2003-2022", SINGLE, _numbered(segments), tuple(_mount(up) for up in UPS))


def _ahrs(case: Case) -> Plan:
    """JJF 1536-2015 with rates instead of accumulated angles: scale factor, turns, zero offset.

    The dwells are those of the case, four times as long for the zero offset; the clause's half
    hours are only longer.
    """
    blocks, mounts = [], []
    for up in ("+x", "+y", "+z"):
        blocks.append([*_rates(case, up), *_turns(up)])
        mounts.append(_mount(up))
    for number, (up, turn) in enumerate((up, turn) for up in ("+z", "-z") for turn in (0, 180)):
        label = {"item": "four_position", "axis": "x", "up": up}
        blocks.append([Segment(f"zero_x_{number + 1}", "static", 4 * case.dwell_s, 0, label)])
        mounts.append(_mount(up, turn))
    segments = [
        replace(segment, fixing=number) for number, block in enumerate(blocks) for segment in block
    ]
    return Plan("JJF 1536-2015", SINGLE, _numbered(segments), tuple(mounts))


def _turns(up: str) -> Iterator[Segment]:
    """Ten turns each way."""
    for sign in (1, -1):
        label = {"item": "misalignment", "axis": up[1], "up": up, "angle_deg": sign * 3600.0}
        angle = sign * 20.0 * np.pi
        name = f"turns_{up[1]}_{sign * 10:+d}"
        yield Segment(name, "rotation", TURNS, 0, label, turn=angle)
        yield Segment(f"pause_{name}", "settle", 5.0, 0, {})
