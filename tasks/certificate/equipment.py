"""Where the limits of the equipment in the budgets come from, and what is in no budget.

A pair is (Chinese, English).
"""

import math
from collections.abc import Iterable

from schemas.calibration import Calibration
from schemas.uncertainty import BudgetInput
from tasks.certificate.fields import listed
from tasks.certificate.names import Pair
from tasks.certificate.typography import clause
from tasks.uncertainty.equipment import GRAVITY, JJF1536, JJF2003, LATITUDE, Equipment
from tasks.words import say
from tasks.words.units import quantity_text

ASSUMED = {
    GRAVITY.clause: (
        "假定：由纬度和高程计算，重力异常不超过 50 mGal",
        "assumed: calculated from latitude and height, anomalies within 50 mGal",
    ),
    LATITUDE.clause: ("假定：纬度给出至 0.1°", "assumed: latitude stated to 0.1°"),
}
RECOMMENDED = (
    "转台和夹具取 {} 推荐的技术指标（视为本装置满足）：{}",
    "for table and fixture the recommended limits of {}, which this equipment is taken to meet: {}",
)
OWN = ("实验室给出的极限：{}", "limits stated by the laboratory: {}")
TAKEN = ("{}假定已知至 {}", "{} assumed known to {}")
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
# The plate tilts with the unit's base, whose length nobody tells, and is one with the mounting.
FLATNESS = {
    "JJF 2003-2022": (
        "台面和夹具的平面度（表 1、6.2：0.02 mm）未列入评定：其引起的倾角取决于被校仪器的安装"
        "基面长度，规范未给出；按 100 mm 计约 41″，大于夹具垂直度的极限。",
        "The flatness of table and fixture (Table 1, 6.2: 0.02 mm) is in no budget: the tilt it "
        "causes depends on the length of the unit's base, which the specification does not give; "
        "over 100 mm it would be about 41″, more than the limit of the fixture's squareness.",
    ),
    "JJF 1536-2015": (
        "夹具的平面度（6.2.2 b）：0.01 mm）未列入评定：其引起的倾角取决于被校仪器的安装基面长度，"
        "规范未给出；按 100 mm 计约 21″，大于夹具垂直度的极限。",
        "The flatness of the fixture (6.2.2 b): 0.01 mm) is in no budget: the tilt it causes "
        "depends on the length of the unit's base, which the specification does not give; over "
        "100 mm it would be about 21″, more than the limit of the fixture's squareness.",
    ),
}


def limits_of(calibration: Calibration) -> tuple[BudgetInput, ...]:
    """Every limit of the equipment that stands in a budget, once."""
    lines = (
        line
        for item in calibration.items.values()
        for budget in item.budgets.values()
        for line in budget.inputs
        if line.source is not None and line.half_width is not None
    )
    return tuple({(line.symbol, line.source): line for line in lines}.values())


def source(line: BudgetInput) -> Pair:
    """Who states a limit: the specification that recommends it, the laboratory, or nobody."""
    said = line.source or ""
    return ASSUMED.get(said) or clause(said)


def half_width(line: BudgetInput) -> str:
    """The half-width of a limit with its unit, angles in arcseconds and the latitude in degrees."""
    assert line.half_width is not None
    if line.unit != "rad":
        return quantity_text(_plain(line.half_width), line.unit)
    degrees = math.degrees(line.half_width)
    return f"{degrees:g}°" if line.symbol == LATITUDE.symbol else f"{3600 * degrees:g}″"


def _plain(number: float) -> str:
    """0.0005, 1×10⁻⁵."""
    digits, _, power = f"{number:g}".partition("e")
    return f"{digits}×10{str(int(power)).translate(RAISED)}" if power else digits


def whose_limits(calibration: Calibration) -> tuple[Pair, ...]:
    """What the type B contributions rest on, and what is not in them; nothing without limits."""
    limits = limits_of(calibration)
    if not limits:
        return ()
    advised = _advised(JJF2003) | _advised(JJF1536)
    assumed = [line for line in limits if line.source in ASSUMED]
    recommended = [line for line in limits if line.source in advised]
    own = [line for line in limits if line not in assumed and line not in recommended]
    parts = []
    if own:
        parts.append(_filled(OWN, listed((line.name_zh, line.name) for line in own)))
    if recommended:
        sources = listed(dict.fromkeys(map(source, recommended)))
        names = listed((line.name_zh, line.name) for line in recommended)
        parts.append(_filled(RECOMMENDED, sources, names))
    for line in assumed:
        parts.append(_filled(TAKEN, (line.name_zh, line.name), (f"±{half_width(line)}",) * 2))
    if _latitude_beside(calibration, limits):
        known = f"±{math.degrees(LATITUDE.half_width):g}°"
        latitude = (say(LATITUDE.name, "zh"), say(LATITUDE.name, "en"))
        parts.append(_filled(TAKEN, latitude, (known,) * 2))
    specification = "JJF 1536-2015" if calibration.method == "jjf1536" else "JJF 2003-2022"
    zh, en = "；".join(zh for zh, _ in parts), "; ".join(en for _, en in parts)
    whose = (f"B 类分量的极限：{zh}。", f"Limits behind type B: {en}.")
    return whose, FLATNESS[specification]


def _latitude_beside(calibration: Calibration, limits: tuple[BudgetInput, ...]) -> bool:
    """Whether the assumed latitude enters by a second value alone, which has no budget."""
    told = "limit of latitude" in calibration.settings
    if told or any(line.symbol == LATITUDE.symbol for line in limits):
        return False
    still = (item.U_without_earth_rotation or {} for item in calibration.items.values())
    return any(U is not None for each in still for U in each.values())


def _filled(form: Pair, *said: Pair) -> Pair:
    return form[0].format(*(zh for zh, _ in said)), form[1].format(*(en for _, en in said))


def _advised(equipment: Equipment) -> set[str]:
    """The clauses from which the limits of a specification come."""
    every: Iterable[str] = (
        *(limit.clause for _, limit in equipment.rates),
        *(limit.clause for limit in (*equipment.angles, *equipment.squareness)),
        *((equipment.ripple.clause,) if equipment.ripple else ()),
    )
    return set(every)
