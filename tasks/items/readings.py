"""The register of readings: where a specification is wrong or silent, and what was taken.

A result names the readings it rests on by their identifier; the certificate prints them.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Reading:
    """How a clause was read: the clause, and the reading in both languages."""

    clause: str
    en: str
    zh: str


READINGS: dict[str, Reading] = {
    "jjf2003.p_turning": Reading(
        "JJF 2003-2022, 7.2.5.2, eq. (12), (13)",
        "U_7 is the mean at rest (7.2.5.1 a) and U_8 the mean while turning (7.2.5.1 b); "
        "the text under the equations calls both “at rest”.",
        "U_7 为静止时均值（7.2.5.1 a），U_8 为转动时均值（7.2.5.1 b）；"
        "公式下的文字将两者均写作“静止”。",
    ),
    "jjf2003.p_sign": Reading(
        "JJF 2003-2022, 5.2 eq. (2) and 7.2.5.2 eq. (12), (13)",
        "Eq. (12), (13) give rest minus turning, which is the negative of p in model (2). The "
        "value by (12), (13) is the clause's result; the value with the sign of model (2) is "
        "stored beside it and is the one to compensate with.",
        "式(12)、式(13)为静止减转动，与模型式(2)中 p 的符号相反。按式(12)、式(13)的值为本条款结果；"
        "符号按模型式(2)的值另行给出，补偿时应使用后者。",
    ),
    "jjf2003.p_lever_arm": Reading(
        "JJF 2003-2022, 7.2.5",
        "With the accelerometers at r from the rotation axis, eq. (12), (13) return the "
        "components of r (in metres) on top of the sensor's own p; the value holds for the "
        "mounting position of this calibration.",
        "加速度计偏离转轴 r 时，式(12)、式(13)的结果包含 r 的分量（单位 m）；"
        "该值仅对本次校准的安装位置有效。",
    ),
    "jjf2003.p_rates": Reading(
        "JJF 2003-2022, 7.2.5.1 b)",
        "The clause does not say at which rate: the largest rate of the run is taken, the mean "
        "over the directions recorded, against the mean of the rests beside it.",
        "条款未规定角速率：取本次最大角速率、各转动方向的均值，与相邻静止均值相比较。",
    ),
    "jjf2003.p_unit": Reading(
        "JJF 2003-2022, 7.2.5.2 and Appendix B, 6",
        "p is given in m/s² per (rad/s)², that is, in metres.",
        "p 的单位为 (m/s²)/(rad/s)²，即 m。",
    ),
    "jjf2003.g_earth": Reading(
        "JJF 2003-2022, 7.2.2.2 eq. (7)",
        "The 180° pairs of 7.2.2.1 cancel only the horizontal part of Earth's rotation; the "
        "diagonal of the g-sensitivity by eq. (7) is too large by ω_e·sin φ per g. The value by "
        "the clause and the value without Earth's rotation are both given.",
        "7.2.2.1 的 180° 翻转仅抵消地球自转的水平分量；式(7)所得对角元每 g 偏大 ω_e·sin φ。"
        "同时给出按条款的值和扣除地球自转后的值。",
    ),
    "jjf2003.input_matrix": Reading(
        "JJF 2003-2022, 7.2.2.2",
        "The input matrix called Ā_a and then Ā_g is one and the same 4 × 6 matrix, in units of "
        "the local gravity.",
        "先后写作 Ā_a 与 Ā_g 的输入矩阵为同一 4 × 6 矩阵，单位为当地重力加速度 g。",
    ),
    "jjf2003.k_azx": Reading(
        "JJF 2003-2022, 5.2, list under eq. (2)",
        "K_axz stands twice in the list; one of them is K_azx.",
        "式(2)下列表中 K_axz 出现两次，其一应为 K_azx。",
    ),
    "jjf2003.k_gzy": Reading(
        "JJF 2003-2022, Appendix B, 3",
        "The list of five gyro cross coupling coefficients lacks K_gzy (Y axis onto Z axis); "
        "all six are given.",
        "附录 B 第 3 项仅列五个陀螺交叉耦合系数，缺 K_gzy（Y 轴对 Z 轴）；此处六个全部给出。",
    ),
    "jjf2003.positions": Reading(
        "JJF 2003-2022, 7.2.2.1 and Appendix C",
        "The twelve positions are X, Y, Z up, then down, each at two headings 180° apart about "
        "the vertical.",
        "十二位置为 X、Y、Z 轴依次朝天、朝地，各在绕天向相差 180° 的两个方位。",
    ),
    "jjf2003.table_rate": Reading(
        "JJF 2003-2022, 7.2.1.2 eq. (4)",
        "The input X of a point is the angle turned by the table's encoder divided by the time; "
        "where no encoder was recorded, the rate of the label.",
        "各点输入 X 取转台编码器转过的角度除以时间；无编码器记录时取标称角速率。",
    ),
    "jjf2003.turned_angle": Reading(
        "JJF 2003-2022, 7.2.1",
        "Turns by a known angle take the place of held rates: the gyro's output less the rests "
        "beside it, integrated over the turn, is divided by the angle. This is not the clause's "
        "method.",
        "以已知转角代替恒定角速率：陀螺输出扣除前后静止值后在转动期间积分，再除以转角。此非条款规定的方法。",
    ),
}
