## 各规范条款有误或未规定之处的理解：reading-<规范>-<内容>。

reading-jjf2003-p-turning = U_7 为静止时均值（7.2.5.1 a），U_8 为转动时均值（7.2.5.1 b）；公式下的文字将两者均写作“静止”。
reading-jjf2003-p-sign = 式(12)、式(13)为静止减转动，与模型式(2)中 p 的符号相反。按式(12)、式(13)的值为本条款结果；符号按模型式(2)的值另行给出，补偿时应使用后者。
reading-jjf2003-p-lever-arm = 加速度计偏离转轴 r 时，式(12)、式(13)的结果包含 r 的分量（单位 m）；该值仅对本次校准的安装位置有效。
reading-jjf2003-p-rates = 条款未规定角速率：取本次最大角速率、各转动方向的均值，与相邻静止均值相比较。
reading-jjf2003-p-unit = p 的单位为 (m/s²)/(rad/s)²，即 m。
reading-jjf2003-g-earth = 7.2.2.1 的 180° 翻转仅抵消地球自转的水平分量；式(7)所得对角元每 g 偏大 ω_e·sin φ。同时给出按条款的值和扣除地球自转后的值。
reading-jjf2003-input-matrix = 先后写作 Ā_a 与 Ā_g 的输入矩阵为同一 4 × 6 矩阵，单位为当地重力加速度 g。
reading-jjf2003-k-azx = 式(2)下列表中 K_axz 出现两次，其一应为 K_azx。
reading-jjf2003-k-gzy = 附录 B 第 3 项仅列五个陀螺交叉耦合系数，缺 K_gzy（Y 轴对 Z 轴）；此处六个全部给出。
reading-jjf2003-positions = 十二位置为 X、Y、Z 轴依次朝天、朝地，各在绕天向相差 180° 的两个方位。
reading-jjf2003-u-gx1 = 求和式中的 N_gx1、N_gx2 应为 U_gx1、U_gx2，即式(7)的输出值。
reading-jjf2003-table-rate = 各点输入 X 取转台编码器转过的角度除以时间；无编码器记录时取标称角速率。
reading-jjf2003-turned-angle = 以已知转角代替恒定角速率：陀螺输出扣除前后静止值后在转动期间积分，再除以转角。此非条款规定的方法。
reading-jjf1536-output-rate = 对于输出累积角度的航姿仪，输出值取每秒角度增量的均值，即该段内累积角度增量除以时间。
reading-jjf1536-table-rate = 输入角速率取转台编码器转过的角度除以时间；无编码器记录时取标称角速率。
reading-jjf1536-zero-time = 各位置输出之和除以 4·T 的整体（n 个位置为 n·T）；原文可读作除以 4 再乘以 T。各位置时间不等时取 N/T 的均值。
reading-jjf1536-earth-cancels = 不另行扣除地球自转：被测轴在各方向等角度分布，地球自转自行抵消；不满足时不给出零偏。
reading-jjf1536-turns-divisor = 正、反转输出之差除以 2×360×n 的整体；式(17)中的 π 应为整周数 n。所得比值（rad）乘以 180/π，以度给出。
reading-jjf1536-l-yz = 式(9)第二行应为 L_yz（Z 轴转动、Y 轴输出），原文误作 L_yx。
reading-jjf1536-index-order = 第一下标为输出轴，第二下标为转动轴，与式(1)、式(7)一致：X 轴对 Y 轴失准角为 L_yx；表 3、7.3 及附录 C 中次序混用。
reading-jjf1536-turned-angle = 2×360×n 取正、反转转过角度之和，以转台编码器为准，无编码器时取标称值。正、反转时间不等时，扣除 7.2 零偏与时间差之积。
reading-jjf1536-product = 逆矩阵后的“+”应为乘号：A = L⁻¹·(N − B·T)。
reading-jjf1536-attitude = 由式(B.1)，航向角为 atan2(−T12, T22)，横滚角为 atan2(−T31, T33)，取全象限。
reading-joint-method = 专利文本公式缺失，理解为：对全部动态、静态采样以最小二乘（按协方差加权）求标度因数与安装误差之积及偏值，再由静止采样修正偏值和 g 敏感系数，迭代至收敛。
reading-joint-g-earth = 已知纬度且静止数据不与之矛盾时，地球自转为已知输入：g 敏感系数不含地球自转，与式(7)的值不同。
reading-joint-fit-offset = 拟合零偏取绕该轴各角速率点读数减去 K·角速率（K 为联合拟合值）的均值，含该姿态下的偏值、g 敏感项及地球自转。
reading-joint-gravity-alone = 仅以重力为参考：各静止位置满足 |K⁻¹·(a − B)| = g。此时体坐标系由加速度计定义：z 为 z 加速度计敏感轴，y 位于 y、z 敏感轴平面内；K_yx、K_zx、K_zy 按定义为零。
reading-joint-gravity-moves = 无转台时，陀螺矩阵由静止位置之间的运动求得：对运动期间的陀螺输出积分，应使前一静止位置的竖直方向转到后一位置的竖直方向。
