"""The calibration items as they are printed: names in both languages, symbols, units.

Elements of an item: the axis that reads, then the input axis. Names and order are those of
Appendix B of JJF 2003-2022 and of Appendix C of JJF 1536-2015.
"""

from dataclasses import dataclass

from schemas.recording import AXES
from schemas.tolerance import Decision, LimitDecision

Pair = tuple[str, str]  # Chinese, English

MATRIX = tuple(reads + given for reads in AXES for given in AXES)
OFF_DIAGONAL = tuple(e for e in MATRIX if e[0] != e[1])
# The input axis first, as Appendix B of the one and Appendix C of the other list them.
APPENDIX_B = ("yx", "zx", "xy", "zy", "xz", "yz")

UNITS = {
    "deg/s": "°/s", "m/s2": "m/s²", "(deg/s)/g": "(°/s)/g", "deg": "°", "deg/h": "°/h",
    "deg/sqrt(h)": "°/√h", "(m/s2)/sqrt(Hz)": "(m/s²)/√Hz",
}  # fmt: skip
ANGLES = {
    "X": ("航向角", "heading angle"),
    "Y": ("俯仰角", "pitch angle"),
    "Z": ("横滚角", "roll angle"),
}


@dataclass(frozen=True)
class ItemName:
    """How an item and its elements are called.

    In `element_*`, {r} is the axis that reads, {i} the input axis and {angle} the attitude
    angle of the axis; the symbol is `letter` with the subscript `sub` and the element.
    """

    zh: str
    en: str
    letter: str
    sub: str
    element_zh: str
    element_en: str
    elements: tuple[str, ...]
    unit: str

    def of(self, element: str) -> Pair:
        """The name of one element, Chinese and English."""
        reads, given = element[0].upper(), element[-1].upper()
        angle_zh, angle_en = ANGLES.get(reads, (reads, reads))
        return (
            self.element_zh.format(r=reads, i=given, angle=angle_zh),
            self.element_en.format(r=reads, i=given, angle=angle_en),
        )

    def subscript(self, element: str) -> str:
        """What stands under the letter: gxx for a diagonal coefficient given as x."""
        return self.sub.format(e=element, twice=element * 2)


ITEMS = {
    "gyro_scale_factor": ItemName(
        "陀螺标度因数", "Gyro scale factor", "K", "g{twice}",
        "{r} 轴陀螺标度因数", "Scale factor of the {r} gyro", AXES, "1"),
    "gyro_fit_offset": ItemName(
        "陀螺拟合零偏", "Gyro fit offset", "b", "{e}",
        "{r} 轴陀螺拟合零偏", "Fit offset of the {r} gyro", AXES, "deg/s"),
    "gyro_bias": ItemName(
        "陀螺零偏", "Gyro bias", "B", "g{e}",
        "{r} 轴陀螺零偏", "Bias of the {r} gyro", AXES, "deg/s"),
    "gyro_cross_coupling": ItemName(
        "陀螺交叉耦合系数", "Gyro cross coupling coefficient", "K", "g{e}",
        "{i} 轴对 {r} 轴交叉耦合系数", "Coupling of the {i} axis onto the {r} gyro",
        APPENDIX_B, "1"),
    "gyro_g_sensitivity": ItemName(
        "陀螺加速度敏感系数", "Gyro g-sensitivity", "g", "{e}",
        "{i} 轴加速度对 {r} 轴陀螺", "{i} acceleration onto the {r} gyro", MATRIX, "(deg/s)/g"),
    "accel_scale_factor": ItemName(
        "加速度计标度因数", "Accelerometer scale factor", "K", "a{twice}",
        "{r} 轴加速度计标度因数", "Scale factor of the {r} accelerometer", AXES, "1"),
    "accel_bias": ItemName(
        "加速度计偏值", "Accelerometer bias", "B", "a{e}",
        "{r} 轴加速度计偏值", "Bias of the {r} accelerometer", AXES, "m/s2"),
    "accel_cross_coupling": ItemName(
        "加速度计交叉耦合系数", "Accelerometer cross coupling coefficient", "K", "a{e}",
        "{i} 轴对 {r} 轴交叉耦合系数",
        "Coupling of the {i} axis onto the {r} accelerometer", APPENDIX_B, "1"),
    "accel_rate_sensitivity": ItemName(
        "加速度计角速度灵敏系数", "Accelerometer rate sensitivity", "p", "{e}",
        "{i} 轴角速度对 {r} 轴加速度计", "{i} rate onto the {r} accelerometer",
        OFF_DIAGONAL, "m"),
    "ahrs_scale_factor": ItemName(
        "标度因数", "Scale factor", "K", "{e}",
        "{r} 轴标度因数", "Scale factor of the {r} axis", AXES, "1"),
    "ahrs_zero_offset": ItemName(
        "零偏", "Zero offset", "B", "{e}",
        "{angle}零偏", "Zero offset of the {angle}", AXES, "deg/s"),
    "ahrs_misalignment": ItemName(
        "失准角", "Misalignment angle", "L", "{e}",
        "{i} 轴对 {r} 轴失准角", "Misalignment of the {i} axis to the {r} axis",
        APPENDIX_B, "deg"),
}  # fmt: skip

QUANTITIES = {
    "value": ("条款给出的值", "the value by the clause"),
    "value_without_earth_rotation": (
        "扣除地球自转后的值",
        "the value with Earth's rotation removed",
    ),
    "value_model": ("符号按模型式(2)的值", "the value with the sign of model (2)"),
}

# Which item has a second value beside the one by its clause.
SECOND_VALUE = {
    "gyro_g_sensitivity": "value_without_earth_rotation",
    "accel_rate_sensitivity": "value_model",
}

# {w}, {zh} and {en} stand for the guard band and its side: tasks.certificate.decisions.
RULES = {
    "simple_acceptance": (
        "简单接受（JCGM 106，8.2）：测得值在允许限内即为符合，不另留保护带（w = 0）",
        "simple acceptance (JCGM 106, 8.2): a measured value inside its limits conforms, without "
        "a guard band (w = 0)",
    ),
    "guard_band": (
        "保护带判定（JCGM 106，8.3）：测得值在接受限 AL 内方为符合，接受限由允许限{zh}移 w = {w}",
        "guard band (JCGM 106, 8.3): a measured value inside its acceptance limits AL conforms; "
        "they lie {en} the limits by w = {w}",
    ),
    "shared_risk": (
        "风险共担（JCGM 106，8.2）：按双方约定，测得值在允许限内即为符合（w = 0）",
        "shared risk (JCGM 106, 8.2): as both parties agreed, a measured value inside its limits "
        "conforms (w = 0)",
    ),
}

KINDS = {
    "type A": ("A 类评定", "type A"),
    "GUM": ("GUM 法，A 类与 B 类合成", "GUM, type A and B combined"),
    "as the specification's example": ("按规范附录 A 示例", "as Appendix A of the specification"),
    "Monte Carlo": ("蒙特卡洛法，A 类与 B 类合成", "Monte Carlo, type A and B combined"),
}

VERDICTS = {
    "pass": ("合格", "pass"),
    "fail": ("不合格", "fail"),
    "inconclusive": ("无法判定", "inconclusive"),
}
# Within U of a limit; the names are those of ILAC-G8:09/2019, 4.2.3.
CONDITIONAL = {
    "pass": ("有条件合格", "conditional pass"),
    "fail": ("有条件不合格", "conditional fail"),
}


def item_name(item: str) -> Pair:
    """The name of an item, Chinese and English; its key where it is not of a specification."""
    return (ITEMS[item].zh, ITEMS[item].en) if item in ITEMS else (item, item)


def verdict_words(decided: Decision | LimitDecision) -> Pair:
    """A verdict in words, with its condition where a value lies within U of a limit."""
    return (CONDITIONAL if decided.marginal else VERDICTS)[decided.verdict]


def unit_text(unit: str) -> str:
    """A unit as it is printed."""
    return UNITS.get(unit, unit)


def quantity_text(number: str, unit: str) -> str:
    """A number with its unit as it is printed; a ratio has none."""
    return number if unit == "1" else f"{number} {unit_text(unit)}"


def symbol(item: str, element: str) -> str:
    """The symbol of an element as plain text, like K_gxx; the element where there is none."""
    named = ITEMS.get(item)
    return f"{named.letter}_{named.subscript(element)}" if named else element
