"""Why cases fail, as far as somebody has found out; the rest says so."""

from collections.abc import Mapping

from tests.proof.text import Text, bilingual

# By what is true (“clean” where nothing is) and what was said: a name, “unnamed” or “nothing”.
KNOWN_CAUSES: Mapping[tuple[str, str], Text] = {
    **dict.fromkeys(
        (("bandwidth", "time_offset"), ("time_offset", "bandwidth")),
        bilingual(
            "a short delay and a low-pass of second order read alike on a turntable: chi-squared "
            "differs by less than 1",
            "在转台上，短时延与二阶低通的输出几乎相同：卡方之差小于1",
        ),
    ),
    **dict.fromkeys(
        (
            ("thermal_gradient", "temperature_bias"),
            ("temperature_bias", "thermal_gradient"),
            ("thermal_gradient", "thermal_transient"),
            ("thermal_transient", "temperature_bias"),
            ("temperature_bias", "thermal_transient"),
        ),
        bilingual(
            "the unit warms as one exponential: temperature, its rate and a warm-up are then the "
            "same course but for a factor and a bias",
            "产品按单一指数规律升温：温度、温变率与预热漂移仅差一个系数和零偏",
        ),
    ),
    **dict.fromkeys(
        (("vibration_rectification", "nothing"), ("vibration_rectification", "unnamed")),
        bilingual(
            "the vibration that is rectified also makes the readings noisier: rows weigh less "
            "where the effect is large",
            "引起整流的振动同时增大读数噪声：效应大处的数据权重反而较小",
        ),
    ),
    ("bias_random_walk", "nothing"): bilingual(
        "a slow wander this small is within what the flicker noise, itself estimated, may do",
        "如此小的缓慢游走在（同样由数据估计的）闪烁噪声可能范围之内",
    ),
    ("earth_rotation", "nothing"): bilingual(
        "its size is what it is, here below what the unit's noise lets be told",
        "其大小固定，此处低于产品噪声的可分辨限",
    ),
}
NOT_KNOWN: Text = bilingual("not looked into", "尚未查明")
FAINT: Text = bilingual(
    "too faint to be told among all the effects looked for",
    "信号过弱，同时搜索全部因素时无法分辨",
)
