"""What the appendices with the certificate's inner pages lay down: order, columns, sentences.

Appendix B of JJF 2003-2022 and Appendix C of JJF 1536-2015. A pair is (Chinese, English).
"""

from tasks.certificate.names import Pair

SECTIONS = {
    "JJF 2003-2022": (
        (("标度因数", "Scale factors"),
         ("gyro_scale_factor", "accel_scale_factor", "gyro_fit_offset")),
        (("零偏", "Biases"), ("gyro_bias", "accel_bias")),
        (("陀螺交叉耦合系数", "Gyro cross coupling coefficients"), ("gyro_cross_coupling",)),
        (("加速度计交叉耦合系数", "Accelerometer cross coupling coefficients"),
         ("accel_cross_coupling",)),
        (("陀螺加速度敏感系数 (g)", "Gyro g-sensitivity (g)"), ("gyro_g_sensitivity",)),
        (("加速度计角速度灵敏系数 (p)", "Accelerometer rate sensitivity (p)"),
         ("accel_rate_sensitivity",)),
    ),
    "JJF 1536-2015": (
        (("标度因数", "Scale factors"), ("ahrs_scale_factor",)),
        (("零偏", "Zero offsets"), ("ahrs_zero_offset",)),
        (("失准角", "Misalignment angles"), ("ahrs_misalignment",)),
    ),
}  # fmt: skip
# The items of Table 2 of the one, of clause 7 of the other.
TABLE_ITEMS = {
    "JJF 2003-2022": (
        "gyro_scale_factor", "gyro_bias", "gyro_g_sensitivity", "gyro_cross_coupling",
        "accel_bias", "accel_scale_factor", "accel_cross_coupling", "accel_rate_sensitivity",
    ),
    "JJF 1536-2015": ("ahrs_scale_factor", "ahrs_zero_offset", "ahrs_misalignment"),
}  # fmt: skip
OTHER = ("其他结果", "Other results")

# Items whose numbers are written in one power of ten, so that they can be compared.
ALIKE = {
    "gyro_cross_coupling": "accel_cross_coupling",
    "accel_cross_coupling": "gyro_cross_coupling",
}

COLUMNS = {
    "gyro_g_sensitivity": (
        ("(a) 式(7)", "(a) by eq. (7)"),
        ("(b) 扣除地球自转", "(b) less Earth's rate"),
    ),
    "accel_rate_sensitivity": (
        ("(a) 式(12)、式(13)", "(a) by eq. (12), (13)"),
        ("(b) 模型式(2)符号", "(b) sign of model (2)"),
    ),
}
JOINT_COLUMNS = {  # of the g-sensitivity the joint fit gives one value
    "accel_rate_sensitivity": (
        ("(a) 式(12)符号", "(a) sign of eq. (12)"),
        ("(b) 模型式(2)符号", "(b) sign of model (2)"),
    ),
}
ONE_COLUMN = (("测得值", "Value"),)

NOT_DECIDED_ON = {
    "gyro_fit_offset": (
        "式(4)的 b 仅供参考，不作判定；陀螺零偏见第 2 项。",
        "b of eq. (4) is given for information and is not decided on; the gyro bias stands in "
        "section 2.",
    ),
}
SENTENCES: dict[str, tuple[Pair, ...]] = {
    "gyro_fit_offset": (
        ("b 由速率点求得，与零偏 B 不同：转轴竖直时，b 还含 g_ii × 1 g "
         "和所敏感的地球自转竖直分量。",
         "b comes from the rate points and differs from the bias B: about a vertical axis b also "
         "holds g_ii × 1 g and what the unit senses of Earth's rotation about that axis."),
    ),
    "gyro_g_sensitivity": (
        ("g 为当地重力加速度。首下标为敏感轴，次下标为输入轴。",
         "g is the local gravity. First index: the axis that reads; second: the input axis."),
    ),
    "accel_rate_sensitivity": (
        ("单位 m 即 (m/s²)/(rad/s)²。(a) 为静止减转动，与模型式(2)中 p 的符号相反；"
         "补偿时应使用 (b)。p 的值仅对本次安装位置有效。",
         "The unit m is m/s² per (rad/s)². (a) is rest minus turning, the negative of p in model "
         "(2); compensate with (b). The values of p hold for this mounting position."),
    ),
}  # fmt: skip
JOINT_SENTENCES: dict[str, tuple[Pair, ...]] = {
    **SENTENCES,
    "accel_rate_sensitivity": (
        ("单位 m 即 (m/s²)/(rad/s)²。联合拟合直接得到模型式(2)的 p，即 (b)，补偿时应使用 (b)；"
         "(a) 为其相反数，与式(12)、式(13)的符号一致。p 的值仅对本次安装位置有效。",
         "The unit m is m/s² per (rad/s)². The joint fit gives p of model (2), which is (b): "
         "compensate with it; (a) is its negative, the sign of eq. (12) and (13). The values of p "
         "hold for this mounting position."),
    ),
}  # fmt: skip
