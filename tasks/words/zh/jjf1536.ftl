## JJF 1536-2015 各条款：缺项原因及不符合条款之处。

jjf1536-slow-sampling = { $count } 段的采样率为 { $rate } Hz；7.2.1 和 7.3.1 要求不少于 { $asked } Hz。

jjf1536-rate-not-read = { $segment }：按标注、安装及转台绕 { $axis } 轴以 { $rate } °/s 转动，但该轴读数为 { $reading } °/s：未取用。
jjf1536-no-rest-before = { $axis } 轴：角速率点前缺少式(11)所需的静止数据；标度因数不受影响，拟合零位受影响。
jjf1536-no-rest-after = { $axis } 轴：角速率点后缺少式(11)所需的静止数据；标度因数不受影响，拟合零位受影响。
jjf1536-no-rest-before-or-after = { $axis } 轴：角速率点前、后缺少式(11)所需的静止数据；标度因数不受影响，拟合零位受影响。
jjf1536-line-scatter = { $axis } 轴：各角速率点对式(13)直线的离散为噪声的 { $factor } 倍，不确定度已按此放大。

jjf1536-no-position = 没有用于零偏的静止数据
jjf1536-few-positions = 仅 { $count } 个位置（需四个），且未记录该轴指向
jjf1536-earth-remains = { $count } 个位置不能抵消地球自转（最多残留 { $percent } %）；式(16)要求等角度间隔的位置
jjf1536-steady-rate-lost = 各位置的读数仅含地球自转的 { $gain } ± { $u }（k = 2），而陀螺应完全敏感：被校航姿仪自行扣除了恒定角速率（如零偏估计），或各位置间未翻转。零偏为扣除后的残余，而非陀螺的零偏，不给出 U；请关闭其零偏估计后再校准。
jjf1536-attitude-contradicted = { $axis } 轴：{ $segments } 标注的指向与转台及安装不符：已按转台及安装取用。
jjf1536-attitude-not-recorded = { $axis } 轴：未记录其指向；{ $count } 个位置是否抵消地球自转未经核实。
jjf1536-number-of-positions = { $axis } 轴：{ $count } 个位置；7.2.1 要求四个，7.2.2 推荐十二个。
jjf1536-short-position = { $axis } 轴：各位置最短 { $minutes } min；7.2 为 { $asked } min，校准时间可根据被校航姿仪工作时间确定。
jjf1536-positions-scatter = { $axis } 轴：各位置之差为地球自转与噪声所能解释的 { $factor } 倍，不确定度已按此放大。

jjf1536-crooked = { $axis } 轴：按安装姿态，转动时其他轴也有输入，须分别绕各轴转动才能确定
jjf1536-no-turns = 没有绕 { $axis } 轴的整周转动
jjf1536-no-back = 缺少绕 { $axis } 轴反转数据；式(17)取正、反转之差
jjf1536-no-forward = 缺少绕 { $axis } 轴正转数据；式(17)取正、反转之差
jjf1536-turn-not-read = 绕 { $axis } 轴转动时该轴读数与转角不符，请核对标注和安装
jjf1536-turns-as-agreed = { $axis } 轴：{ $count } 周，{ $rate } °/s；技术协议未另行规定时，7.3.1 为 { $turns_asked } 周、高角速率（如 { $rate_asked } °/s）。
jjf1536-turn-times-differ = { $axis } 轴：正、反转时间相差 { $seconds } s；其间零偏和重力引起的转角未抵消（零偏已知时已扣除）。
jjf1536-turned-angle-contradicted = { $segment }：标注绕 { $axis } 轴 { $label }°，但转台显示 { $table }°：已按转台角度取用。
jjf1536-turned-angle-wrong = { $axis } 轴：转动时其读数比按标度因数由转角得到的多 { $percent } %：部分转动不在所标注的时段内，转角有误，或标度因数已变。绕 { $axis } 轴的失准角不给出 U。
jjf1536-not-whole-turns = { $segment }：转过 { $angle }°，非 7.3.1 要求的整周，地球自转未抵消。

## 证书结果的各节。

section-ahrs-scale-factors = 标度因数
section-ahrs-zero-offsets = 零偏
section-ahrs-misalignment = 失准角
