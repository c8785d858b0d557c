"""What the measuring equipment may be wrong by: Table 1 of JJF 2003-2022 and of JJF 1536-2015.

The defaults are the tables' own recommendations; a laboratory's own limits go before them
(`with_limits`). Where a table is silent the entry says «assumed».
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from schemas.certificate import EquipmentLimit, LimitName
from schemas.station import LimitShape
from tasks.uncertainty.budget import InputQuantity

ARCSECOND = math.radians(1.0 / 3600.0)
EDGE = 0.99  # of the rate where a limit begins: a table holds 10 °/s to its own errors
# Half-width over standard uncertainty, GUM 4.3 (JJF 1059.1 Table 3); a certificate's U has k = 2.
DIVISORS = {
    "normal": 2.0,
    "rectangular": math.sqrt(3.0),
    "triangular": math.sqrt(6.0),
    "arcsine": math.sqrt(2.0),
}


@dataclass(frozen=True)
class Limit:
    """How far one property of the equipment may be from its stated value, and who says so.

    half_width: in `unit`; for «normal» it is an expanded uncertainty with k = 2.
    """

    symbol: str
    name: str
    name_zh: str
    unit: str
    half_width: float
    distribution: LimitShape
    clause: str

    @property
    def u(self) -> float:
        """Standard uncertainty, half-width over the divisor of the distribution."""
        return self.half_width / DIVISORS[self.distribution]

    def quantity(self) -> InputQuantity:
        """The limit as an input quantity of type B, with infinitely many degrees of freedom."""
        return InputQuantity(
            self.symbol, self.name, self.name_zh, self.unit, self.u, "B", self.distribution,
            half_width=self.half_width, source=self.clause,
        )  # fmt: skip


@dataclass(frozen=True)
class Equipment:
    """Table, fixture and site of a calibration; None: not known, or not there.

    rates: relative error of the mean rate over whole turns, each limit from its slowest rate
    (rad/s) on, fastest first; ripple: within a turn.
    position, repeatability: of each table angle. axes: between the table's axes.
    fixture: between the fixture's faces.
    """

    rates: tuple[tuple[float, Limit], ...]
    ripple: Limit | None
    position: Limit | None
    repeatability: Limit | None
    axes: Limit | None
    fixture: Limit | None
    gravity: Limit
    latitude: Limit

    @property
    def angles(self) -> tuple[Limit, ...]:
        """What turns the unit by an error of its own in every position, rad."""
        each = (self.position, self.repeatability)
        return tuple(limit for limit in each if limit is not None)

    @property
    def squareness(self) -> tuple[Limit, ...]:
        """What turns the unit by an error common to all positions of one mounting, rad."""
        return tuple(limit for limit in (self.axes, self.fixture) if limit is not None)

    def rate_at(self, rate: float) -> tuple[Limit, ...]:
        """The limit of the mean rate at a rate (rad/s); empty where none is known.

        A rate up to 1 % below where a limit begins is meant to have it.
        """
        limits = (limit for slowest, limit in self.rates if abs(rate) >= EDGE * slowest)
        return tuple(limits)[:1]


GRAVITY = Limit(
    "g", "local gravity", "当地重力加速度", "m/s2", 5e-4, "rectangular",
    "assumed: gravity from latitude and height, anomalies within 50 mGal",
)  # fmt: skip
LATITUDE = Limit(
    "φ", "latitude", "纬度", "rad", math.radians(0.05), "rectangular",
    "assumed: latitude stated to 0.1°",
)  # fmt: skip


def _jjf2003(symbol: str, name: str, zh: str, unit: str, half_width: float, clause: str) -> Limit:
    return Limit(symbol, name, zh, unit, half_width, "rectangular", f"JJF 2003-2022, {clause}")


RATE = _jjf2003("ε1", "table rate, whole turns", "转台角速率（360°平均）", "1", 1e-5, "Table 1")
JJF2003 = Equipment(
    rates=((0.0, RATE),),
    ripple=_jjf2003("ε2", "table rate within a turn", "转台角速率平稳性", "1", 5e-4, "Table 1"),
    position=_jjf2003(
        "α1", "angular positioning", "角位置定位精度", "rad", 10 * ARCSECOND, "Table 1"
    ),
    repeatability=_jjf2003(
        "α2", "repeatability of angle", "角位置测量重复性", "rad", 5 * ARCSECOND, "Table 1"
    ),
    axes=_jjf2003("α3", "squareness of axes", "轴线垂直度", "rad", 10 * ARCSECOND, "Table 1"),
    fixture=_jjf2003("α4", "squareness of fixture", "夹具垂直度", "rad", 10 * ARCSECOND, "6.2"),
    gravity=GRAVITY,
    latitude=LATITUDE,
)


def _jjf1536_rate(symbol: str, en: str, zh: str, U: float) -> Limit:
    """A row of Table 1 of JJF 1536-2015: U_rel of the rate, k = 2."""
    clause = "JJF 1536-2015, Table 1"
    return Limit(symbol, f"table rate {en}", f"转台角速率（{zh}）", "1", U, "normal", clause)


JJF1536 = Equipment(
    rates=(
        (math.radians(10.0), _jjf1536_rate("ε1", "from 10 °/s", "≥ 10 °/s", 2e-4)),
        (math.radians(1.0), _jjf1536_rate("ε2", "1 to 10 °/s", "1~10 °/s", 2e-3)),
        (0.0, _jjf1536_rate("ε3", "below 1 °/s", "< 1 °/s", 2e-2)),
    ),
    ripple=None,
    position=Limit(
        "α1", "table angle", "转台角位移", "rad", 10 * ARCSECOND, "normal",
        "JJF 1536-2015, Table 1",
    ),
    repeatability=None,
    axes=None,
    fixture=Limit(
        "α4", "squareness of fixture", "夹具垂直度", "rad", 5 * ARCSECOND, "rectangular",
        "JJF 1536-2015, 6.2.2 b)",
    ),
    gravity=GRAVITY,
    latitude=LATITUDE,
)  # fmt: skip

# A unit turned by hand, on a pillar, or on a table that nobody describes.
UNKNOWN = Equipment((), None, None, None, None, None, GRAVITY, LATITUDE)


def with_limits(equipment: Equipment, own: Mapping[LimitName, EquipmentLimit]) -> Equipment:
    """The equipment with a laboratory's own limits in the place of the specification's."""
    changed: dict[str, object] = {}
    for name, told in own.items():
        known = RATE if name == "rate" else getattr(JJF2003, name)
        limit = replace(
            known,
            half_width=told.half_width,
            distribution=told.distribution,
            clause=told.source,
        )
        changed |= {"rates": ((0.0, limit),)} if name == "rate" else {name: limit}
    return replace(equipment, **changed)  # type: ignore[arg-type]
