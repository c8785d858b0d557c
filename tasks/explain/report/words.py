"""Words and numbers of the report: names, quantities with U in sensible units, plain evidence."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from schemas.discrepancy import FoundParameter, Statement
from tasks.explain.correction.consequences import OVERALL
from tasks.model.term import Text
from tasks.specifications.items import ITEMS, item_title
from tasks.words import message, statement
from tasks.words.rounding import MINUS, USUAL_K, column
from tasks.words.units import unit_text

EFFECTS: dict[str, Text] = {
    "earth_rotation": ("Earth's rotation", "地球自转"),
    "gravity_value": ("another value of gravity", "重力值不符"),
    "lever_arm": ("a lever arm", "杆臂"),
    "size_effect": ("a size effect of the accelerometers", "加速度计尺寸效应"),
    "axis_tilt": ("a tilted table base", "转台基座倾斜"),
    "axis_nonorthogonality": ("table axes not square to each other", "转台轴系不垂直"),
    "axis_wobble": ("a wobbling rotation axis", "转轴摆动"),
    "structural_compliance": ("a fixture that bends with rate²", "夹具随角速度平方变形"),
    "remount_misalignment": ("another attitude after each re-fixing", "重新装夹后姿态变化"),
    "rate_ripple": ("a ripple of the table's rate", "转台速率波动"),
    "encoder_eccentricity": ("an eccentric encoder", "编码器偏心"),
    "table_scale": ("a wrong scale of the table's angle", "转台角度刻度误差"),
    "time_offset": ("an offset between the clocks", "时钟偏移"),
    "clock_skew": ("a clock that runs fast or slow", "时钟频率偏差"),
    "accel_axis_skew": ("accelerometer axes sampled one after another", "加速度计各轴依次采样"),
    "dropped_samples": ("lost samples", "丢失采样"),
    "gyro_scale_nonlinearity": ("gyro scale factor depends on rate", "陀螺标度因数非线性"),
    "gyro_scale_asymmetry": ("gyro scale factor depends on sign", "陀螺标度因数不对称"),
    "gyro_saturation": ("gyro saturation", "陀螺饱和"),
    "gyro_g2_sensitivity": ("gyro g² sensitivity", "陀螺 g² 敏感"),
    "gyro_scale_g_dependence": ("gyro scale factor depends on g", "陀螺标度因数随加速度变化"),
    "gyro_angular_acceleration": ("gyro follows angular acceleration", "陀螺角加速度敏感"),
    "accel_nonlinearity": ("accelerometer non-linearity", "加速度计非线性"),
    "accel_saturation": ("accelerometer saturation", "加速度计饱和"),
    "vibration_rectification": ("vibration rectification", "振动整流"),
    "temperature_bias": ("bias follows temperature", "零偏随温度变化"),
    "temperature_scale": ("scale factor follows temperature", "标度因数随温度变化"),
    "thermal_transient": ("a warm-up transient", "热启动过渡过程"),
    "thermal_gradient": ("bias follows the rate of temperature change", "零偏随温度变化率变化"),
    "supply_sensitivity": ("bias follows the supply voltage", "零偏随供电电压变化"),
    "magnetic_sensitivity": ("bias follows Earth's magnetic field", "零偏随地磁场变化"),
    "bandwidth": ("the unit's low-pass", "低通带宽"),
    "coarse_quantisation": ("coarse quantisation", "量化过粗"),
    "mains_pickup": ("mains pick-up", "工频干扰"),
    "hysteresis": ("hysteresis", "迟滞"),
    "bias_step": ("a bias step", "零偏跳变"),
    "bias_random_walk": ("a wandering bias", "零偏随机游走"),
    "unnamed": ("an effect outside the catalogue", "目录之外的效应"),
}

SENSORS = {"gyro": ("gyro", "陀螺"), "accel": ("accelerometer", "加速度计")}
PREFIXES = ("m", "s", "rad", "m/s2", "V", "T")  # units that take the letters
LETTERS = {-3: "m", -6: "µ", -9: "n"}
SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
RATES = {"rad/s": math.degrees(1.0), "deg/s": 1.0}  # what is printed in °/s or °/h
SLOW = 0.01  # °/s; below it a rate is easier read in °/h
PLAIN = 0.01  # a smaller number is printed with a power of ten
BEYOND = 100  # a power of ten that a probability is not worth telling beyond
VERY_STRONG, STRONG, POSITIVE = 10.0, 6.0, 2.0  # ΔBIC, Kass and Raftery, JASA 90 (1995) 773


def effect_name(effect: str) -> Text:
    """What an effect is called in a sentence; its own name spelled out where it has none."""
    spelled = effect.replace("_", " ")
    return EFFECTS.get(effect, (spelled, spelled))


def channels_of(told: str) -> list[str]:
    """The channels that an entry of `Where` names, mostly one: «gyro_x, gyro_y»."""
    return [each.strip() for each in told.split(",")]


def channel_name(told: str) -> Text:
    """«gyro x», «陀螺 x»; several where several are told."""
    return joined([_one_channel(each) for each in channels_of(told)], ", ", "、")


def _one_channel(channel: str) -> Text:
    sensor, _, axis = channel.partition("_")
    en, zh = SENSORS.get(sensor, (sensor, sensor))
    return (f"{en} {axis}".strip(), f"{zh} {axis}".strip())


def element_name(item: str, element: str) -> Text:
    """An element of a certificate's item, English and Chinese."""
    if item == OVERALL:
        return ("the certificate as a whole", "证书总结论")
    if item in ITEMS and set(element) <= set("xyz") and element:
        return text_of(statement(ITEMS[item].element_title(element)))
    en, zh = text_of(statement(item_title(item)))
    return (f"{en} {element}".strip(), f"{zh} {element}".strip())


def text_of(statement: Statement) -> Text:
    """A statement as a pair."""
    return (statement.en, statement.zh)


def verdict_text(verdict: str) -> Text:
    """A verdict of a certificate."""
    return text_of(statement(message(f"conformity-verdict.{verdict}")))


def joined(texts: Sequence[Text], en: str = "; ", zh: str = "；") -> Text:
    """Several pairs as one."""
    return (en.join(t[0] for t in texts), zh.join(t[1] for t in texts))


def capital(text: Text) -> Text:
    """A pair that begins like a sentence; a symbol stays as it is."""
    en, zh = text
    word = en[1:2].islower() or en.startswith("a ")
    return (en[:1].upper() + en[1:] if word else en, zh)


def sentence(text: Text) -> Text:
    """A pair that begins like a sentence and ends with one full stop each."""
    en, zh = capital((text[0].strip().rstrip(".。"), text[1].strip().rstrip(".。")))
    return (f"{en}.", f"{zh}。")


def power_of_ten(exponent: int) -> str:
    """«×10⁻⁶», or nothing."""
    return f"×10{str(exponent).translate(SUPERSCRIPTS)}" if exponent else ""


@dataclass(frozen=True)
class Scale:
    """How a number is printed: value·factor / 10^exponent in `unit`."""

    factor: float
    exponent: int
    unit: str


def sensible(largest: float, unit: str) -> Scale:
    """A scale in which a number of this size is neither long nor all zeros."""
    factor = 1.0
    if unit in RATES:
        in_degrees = RATES[unit] * largest
        slow = 0.0 < in_degrees < SLOW
        factor, unit = RATES[unit] * (3600.0 if slow else 1.0), "deg/h" if slow else "deg/s"
        largest *= factor
    elif unit.startswith("(rad/s)"):
        factor, unit = RATES["rad/s"], unit.replace("(rad/s)", "(deg/s)", 1)
        largest *= factor
    if not 0.0 < largest < (1.0 if unit in PREFIXES else PLAIN):
        return Scale(factor, 0, unit)
    exponent = 3 * math.floor(math.log10(largest) / 3)
    if unit not in PREFIXES:
        return Scale(factor, exponent, unit)
    told = max(exponent, min(LETTERS))
    return Scale(factor / 10.0**told, 0, LETTERS[told] + unit)


def printed_unit(unit: str) -> str:
    """A unit as it is printed; a ratio has none."""
    if unit == "1":
        return ""
    told = unit_text(unit).replace("m/s2", "m/s²").replace("^2", "²").replace("^3", "³")
    return told.replace("deg", "°").replace("*", "·")


def quantity(value: float, U: float, unit: str, like: float = 0.0) -> str:
    """«(9.66 ± 0.40) °/h», «(2.01 ± 0.12)×10⁻⁶»; without ± where there is no U.

    like: a larger value that stands beside it and shares its unit.
    """
    number, expanded, power, told = numbers(value, U, unit, like)
    shown = printed_unit(told)
    body = number if expanded is None else f"{number} ± {expanded}"
    if expanded is not None and (power or shown):
        body = f"({body})"
    return f"{body}{power} {shown}".strip()


def numbers(
    value: float, U: float, unit: str, like: float = 0.0
) -> tuple[str, str | None, str, str]:
    """Value and U (None without one) as texts, their power of ten («×10⁻⁶»), and their unit."""
    scale = sensible(max(abs(value), U, abs(like)), unit)
    by = scale.factor / 10.0**scale.exponent
    made = column([value * by], [U * by if U > 0 else None], USUAL_K)
    power = power_of_ten(scale.exponent + made.exponent)
    return made.values[0] or "0", made.uncertainties[0], power, scale.unit


def parameter_text(parameter: FoundParameter) -> str:
    """«vertical rate = (9.66 ± 0.40) °/h»; U = 2 u."""
    spelled = parameter.name.replace("_", " ")
    return f"{spelled} = {quantity(parameter.value, USUAL_K * parameter.u, parameter.unit)}"


def plain(number: float, digits: int = 3) -> str:
    """A bare number with few digits and a real minus sign."""
    size = abs(number)
    shown = f"{number:.0f}" if 10.0**digits <= size < 1e6 else f"{number:.{digits}g}"
    mantissa, mark, exponent = shown.partition("e")
    power = power_of_ten(int(exponent)) if mark else ""
    return mantissa.replace("-", MINUS) + power


def probability(p: float) -> str:
    """«p = 0.41», «p < 10⁻¹²»."""
    return "p < 10⁻¹²" if p < 1e-12 else f"p = {plain(p, 2)}"


def percent(share: float) -> str:
    """A share as «62 %»."""
    return "< 1 %" if 0.0 < share < 0.005 else f"{100 * share:.0f} %".replace("-", MINUS)


def in_expanded(change: float, U: float) -> str:
    """A change as a multiple of U, «+9.0»."""
    ratio = change / U
    if abs(ratio) >= 1e4:
        return ("+" if ratio > 0 else "") + plain(ratio, 2)
    return f"{ratio:+.{1 if abs(ratio) < 99.95 else 0}f}".replace("-", MINUS)


def bic_words(delta_bic: float) -> Text:
    """What a gain in the Bayesian information criterion is worth, in words."""
    if delta_bic > VERY_STRONG:
        return ("very strong evidence", "证据非常强")
    if delta_bic > STRONG:
        return ("strong evidence", "证据强")
    if delta_bic > POSITIVE:
        return ("some evidence", "有一定证据")
    return ("no evidence by this measure", "按此指标无证据")


def times_more_probable(nats: float) -> Text:
    """e^nats as a number one can read, in both languages."""
    power = nats / math.log(10.0)
    if power > BEYOND:
        beyond = power_of_ten(BEYOND)[1:]
        return (f"more than {beyond} times", f"{beyond} 倍以上")
    shown = plain(math.exp(nats), 2) if power < 3 else power_of_ten(round(power))[1:]
    return (f"{shown} times", f"{shown} 倍")


def chi2(value: float) -> str:
    """A χ² per degree of freedom."""
    return f"{value:.2f}" if abs(value) < 100 else plain(value)
