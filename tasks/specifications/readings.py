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
    "jjf2003.u_gx1": Reading(
        "JJF 2003-2022, Appendix A, A.3.2.3",
        "N_gx1 and N_gx2 in the sum are U_gx1 and U_gx2, the readings of eq. (7).",
        "求和式中的 N_gx1、N_gx2 应为 U_gx1、U_gx2，即式(7)的输出值。",
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
    "jjf1536.output_rate": Reading(
        "JJF 1536-2015, 7.1.1 b), d) and 7.1.2 eq. (10)",
        "The output of a unit that accumulates angles is the mean of its increments per second: "
        "the angle gained over the segment divided by its time.",
        "对于输出累积角度的航姿仪，输出值取每秒角度增量的均值，即该段内累积角度增量除以时间。",
    ),
    "jjf1536.table_rate": Reading(
        "JJF 1536-2015, 7.1.2 eq. (13)",
        "The input rate of a point is the angle turned by the table's encoder divided by the "
        "time; where no encoder was recorded, the rate of the label.",
        "输入角速率取转台编码器转过的角度除以时间；无编码器记录时取标称角速率。",
    ),
    "jjf1536.zero_time": Reading(
        "JJF 1536-2015, 7.2.3 eq. (16) and eq. (A.4)",
        "The sum over the positions is divided by the whole of 4·T (n·T for n positions); "
        "printed, it reads as a division by 4 and a multiplication by T. Where the times differ, "
        "the mean of N/T is taken.",
        "各位置输出之和除以 4·T 的整体（n 个位置为 n·T）；原文可读作除以 4 再乘以 T。"
        "各位置时间不等时取 N/T 的均值。",
    ),
    "jjf1536.earth_cancels": Reading(
        "JJF 1536-2015, 7.2.1, 7.2.2",
        "Earth's rotation is not subtracted: the axis points as often one way as the other, and "
        "positions in which it does not give no zero offset.",
        "不另行扣除地球自转：被测轴在各方向等角度分布，地球自转自行抵消；不满足时不给出零偏。",
    ),
    "jjf1536.turns_divisor": Reading(
        "JJF 1536-2015, 5.6 to 5.8 eq. (7), (8), (9) and 7.3.2 eq. (17)",
        "The difference of both directions is divided by the whole of 2 × 360 × n; the π of (17) "
        "is n, the number of turns. The ratio (rad) is multiplied by 180/π and given in degrees.",
        "正、反转输出之差除以 2×360×n 的整体；式(17)中的 π 应为整周数 n。"
        "所得比值（rad）乘以 180/π，以度给出。",
    ),
    "jjf1536.l_yz": Reading(
        "JJF 1536-2015, 5.8 eq. (9)",
        "The second line of (9) is L_yz (Z turns, Y reads); L_yx is printed.",
        "式(9)第二行应为 L_yz（Z 轴转动、Y 轴输出），原文误作 L_yx。",
    ),
    "jjf1536.index_order": Reading(
        "JJF 1536-2015, 7.3.1, Table 3, 7.3.2 eq. (17) and Appendix C",
        "The first index is the axis that reads, the second the axis that turns, as in eq. (1) and "
        "(7): the misalignment of the X axis to the Y axis is L_yx. Table 3, 7.3 and Appendix C "
        "mix the order.",
        "第一下标为输出轴，第二下标为转动轴，与式(1)、式(7)一致：X 轴对 Y 轴失准角为 L_yx；"
        "表 3、7.3 及附录 C 中次序混用。",
    ),
    "jjf1536.turned_angle": Reading(
        "JJF 1536-2015, 7.3.2 eq. (17)",
        "2 × 360 × n is the angle turned forward plus the angle turned back, by the table's "
        "encoder, else by the label. Where both ways took different times, the zero offset of "
        "7.2 times the difference is taken off.",
        "2×360×n 取正、反转转过角度之和，以转台编码器为准，无编码器时取标称值。"
        "正、反转时间不等时，扣除 7.2 零偏与时间差之积。",
    ),
    "jjf1536.product": Reading(
        "JJF 1536-2015, 5.1 eq. (2)",
        "The sign after the inverse matrix is a product: A = L⁻¹·(N − B·T).",
        "逆矩阵后的“+”应为乘号：A = L⁻¹·(N − B·T)。",
    ),
    "jjf1536.attitude": Reading(
        "JJF 1536-2015, Appendix B eq. (B.4)",
        "By (B.1), heading is atan2(−T12, T22) and roll atan2(−T31, T33), over all quadrants.",
        "由式(B.1)，航向角为 atan2(−T12, T22)，横滚角为 atan2(−T31, T33)，取全象限。",
    ),
    "joint.method": Reading(
        "JJF 2003-2022, 5.1 eq. (1), 5.2 eq. (2)",
        "The patent's formulas are cut off; read as: least squares, weighted by the covariance of "
        "the samples, for scale factor times installation error, and bias, over all dynamic and "
        "static samples; then bias and g-sensitivity from the rests; repeated until nothing "
        "changes.",
        "专利文本公式缺失，理解为：对全部动态、静态采样以最小二乘（按协方差加权）"
        "求标度因数与安装误差之积及偏值，"
        "再由静止采样修正偏值和 g 敏感系数，迭代至收敛。",
    ),
    "joint.g_earth": Reading(
        "JJF 2003-2022, 5.1 eq. (1)",
        "Earth's rotation is a known input where the latitude is told and the rests do not refute "
        "it: the g-sensitivity is without it, unlike the value by eq. (7).",
        "已知纬度且静止数据不与之矛盾时，地球自转为已知输入：g 敏感系数不含地球自转，"
        "与式(7)的值不同。",
    ),
    "joint.fit_offset": Reading(
        "JJF 2003-2022, 7.2.1.2 eq. (4)",
        "The offset is the mean of reading less K·rate over the rate points about the axis, K "
        "of the joint fit; it contains bias, g-sensitivity and Earth's rotation at that attitude.",
        "拟合零位取绕该轴各角速率点读数减去 K·角速率（K 为联合拟合值）的均值，含该姿态下的偏值、"
        "g 敏感项及地球自转。",
    ),
    "joint.gravity_alone": Reading(
        "JJF 2003-2022, 5.2 eq. (2)",
        "With gravity as the only reference, |K⁻¹·(a − B)| = g in every rest. The body axes are "
        "then defined by the accelerometers: z is the z accelerometer's own axis, y lies in the "
        "plane of those of y and z; K_yx, K_zx and K_zy are zero by definition.",
        "仅以重力为参考：各静止位置满足 |K⁻¹·(a − B)| = g。此时体坐标系由加速度计定义："
        "z 为 z 加速度计敏感轴，y 位于 y、z 敏感轴平面内；K_yx、K_zx、K_zy 按定义为零。",
    ),
    "joint.gravity_moves": Reading(
        "JJF 2003-2022, 5.1 eq. (1)",
        "Without a table the gyro's matrix comes from the moves between rests: its readings, "
        "integrated over a move, must turn the vertical of one rest into that of the next.",
        "无转台时，陀螺矩阵由静止位置之间的运动求得：对运动期间的陀螺输出积分，"
        "应使前一静止位置的竖直方向转到后一位置的竖直方向。",
    ),
}
