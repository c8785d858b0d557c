## 条款结果之外数据所示的内容。标题按结果名；.text：求得方法。

information-earth-gain = 静止数据中地球自转的增益
    .text = { $shown }。λ = { $gain } ± { $spread }（k = 2；1 为完全存在，0 为不存在），其中 ± 仅为 A 类；纬度、航向和安放的影响未评定，故不给出 U。
information-without-earth = 扣除地球自转的陀螺加速度敏感系数
    .text = 已从对角元扣除地球自转的竖直分量 ω_e·sin φ；{ $difference }U 的评定同该项结果。
information-earth-present = 式(7)的值含该分量，最多偏离 U 的 { $times } 倍。
information-earth-not-shown = 由此最多改变 U 的 { $times } 倍，而数据中没有地球自转：仿真或已补偿的数据不得使用该值，否则重复扣除。
information-earth-unknown = 由此最多改变 U 的 { $times } 倍。仅凭数据不能判断式(7)的值是否含该分量。

information-lever-arm = 加速度计至转轴的位置（杆臂）
    .text = 加速度计的公共点相对于各转轴交点的位置（体坐标系），由升降速段的 α × r 和转动段的 ω × (ω × r) 求得。
information-without-lever-arm = 扣除杆臂的加速度计角速度灵敏系数
    .text = 式(12)、式(13)的值含杆臂；升降速段可将二者区分。符号与式(12)一致。

information-nonlinearity = 标度因数非线性度
    .text = 各速率点对拟合直线的最大偏差与最大输出之比；含转台的影响。
information-asymmetry = 标度因数不对称性
    .text = 正、反转标度因数之差与其均值之比。
information-more-than-noise = 超出噪声：{ $axes }。
information-no-more-than-noise = 各轴均未超出噪声。

information-gyro-bias-repeatability = 陀螺零偏重复性
information-gyro-scale-repeatability = 陀螺标度因数重复性
information-accel-bias-repeatability = 加速度计偏值重复性
information-accel-scale-repeatability = 加速度计标度因数重复性
information-ahrs-bias-repeatability = 各轴零偏重复性
information-ahrs-scale-repeatability = 各轴标度因数重复性
information-repetition = 本次测量内单次重复的标准差；自由度：{ $dof }。

information-gyro-angle-random-walk = 陀螺角度随机游走系数
information-gyro-bias-instability = 陀螺零偏不稳定性
information-accel-velocity-random-walk = 加速度计速度随机游走系数
information-accel-bias-instability = 加速度计偏值不稳定性
information-ahrs-angle-random-walk = 各轴角度随机游走系数
information-ahrs-bias-instability = 各轴零偏不稳定性
information-rests = { $count } 段 { $seconds } s 静止数据
information-random-walk = 由{ $source }的重叠 Allan 方差中的白噪声项求得（IEEE Std 952）。
information-bias-instability = 由{ $source }的 Allan 标准差最小值除以 0.664 求得。
information-noise-hidden = { $axes }：输出分辨力掩盖了噪声。
information-no-white-noise = { $axes }：未见白噪声。
information-averaging-times = 平均时间：{ $axes }。
information-no-floor = { $axes }：平均时间至 { $tau } s 未见最小值，需更长的静止时间。

information-type-b =
    .contained = U 含 A 类及装置引入的 B 类分量。
    .not-evaluated = 不给出 U：装置对该量的影响未评定。
    .in-part = { $elements }：装置对该值的影响未评定，故不给出 U。
    .unit-and-table = 为被校对象与转台共同的结果，U 不另计装置的分量。
information-few-degrees-of-freedom = { $axes }：自由度过少，按 t 分布得到的 U 将使下限小于零，故不给出 U。
