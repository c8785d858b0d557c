## 模型与记录的差异：比较对象、残差的变化规律、对各校准项目的影响。

# 记录的比较对象。
explain-model-fitted = 参数由本次记录拟合的标准模型
explain-model-calibration = 采用给定校准结果的标准模型
explain-model-simulation = 给定的仿真信号
explain-simulation-of-other-unit = 仿真文件标明的产品为 { $its }，而记录的产品为 { $own }

# 目录之外效应的变化规律。
explain-other-parameters = 标准模型自身参数与给定值不同
explain-jumps = 在多个时刻的电平跳变
behaviour-motion = 与给定运动不同的运动
behaviour-input = 与给定输入不同的输入
behaviour-sensor = 随输入变化的偏差
behaviour-signal = 随信号过程变化的偏差
behaviour-event = 与相邻样本不同的样本
explain-remainder = 不符合任何所查找规律的剩余残差（占高出噪声的失配的 { $share }，主要在 { $low } 至 { $high } Hz）
explain-slow-drift = 与任何记录量均无关的缓慢漂移
explain-unlisted-heating = 转动生热引起的误差，温度计未测得，含不止一个时间常数
explain-unlisted-hysteresis = 零偏滞环，其形式未见于文献
explain-unlisted-non-linearity = 非线性，其形式未见于文献
explain-unlisted-rectification = 振动整流误差，其形式未见于文献
explain-unlisted-late-temperature = 滞后于温度的温度影响，其形式未见于文献
explain-unlisted-attitude = 随姿态变化的误差，其形式未知
explain-unlisted-other-rates = 随其他轴角速率变化的误差，其形式未知
explain-unlisted-angular-acceleration = 随角加速度变化的误差，其形式未见于文献
explain-unlisted-fixture = 工装随姿态或转速变形，其形式未见于文献
explain-unlisted-supply = 随供电电压变化的误差，其形式未见于文献
explain-scale-factor-drift = 标度因数随时间漂移，与任何记录量均无关
explain-wave = 周期约 { $period } s 的波动
explain-relaxation = { $event }后的弛豫，时间常数约 { $tau } s
explain-event-reposition = 每次转位
explain-event-gravity-turn = 每次重力方向改变
explain-event-stop = 每次停止转动
explain-follows = 读数随{ $signal }变化
explain-lag = 读数随{ $signal }变化，滞后约 { $tau } s
explain-signal-own-rate = 自身轴角速率
explain-signal-squared-rate = 角速率平方
explain-signal-rate-size = 角速率大小
explain-signal-own-force = 自身轴比力
explain-signal-own-force-size = 自身轴比力大小
explain-product-other-rates = 读数随另两轴角速率之积变化
explain-product-own-rate = 读数随自身轴与其他轴角速率之积变化
explain-product-other-forces = 读数随另两轴比力之积变化
explain-product-own-force = 读数随自身与其他轴比力之积变化
explain-product-squared-other-forces = 读数随其他轴比力的平方变化
explain-product-squared-other-rates = 读数随角速率的平方变化
explain-product-squared-own-rate = 读数随自身轴角速率的平方变化
explain-product-rates = 读数随角速率变化
explain-product-other-rate-sizes = 读数随其他轴角速率的大小变化
explain-product-fourth-power = 读数随角速率的四次方变化
explain-product-angular-acceleration = 读数随角加速度变化
explain-product-angular-acceleration-size = 读数随角加速度的大小变化
explain-recorded-humidity = 湿度
explain-recorded-pressure = 气压
explain-recorded-air-temperature = 环境温度
explain-recorded-times-input = { $signal }与输入之积
explain-harmonic = 读数随转台第 { $axis } 轴转角变化，每转 { $order } 次
explain-lean = 转台第 { $axis } 轴转角 { $angle }° 附近的倾斜
explain-tip = 产品随比力指向（{ $side }）或其反方向而向两侧等量倾斜
explain-lost-motion = 产品相对转台第 { $axis } 轴编码器滞后一固定角度，方向取决于最近一次转动的方向

# 搜索提前结束。

# 所发现因素对各校准项目的影响。
explain-items-by-angles = JJF 1536 各项由累积角度得到，而非由所解释的角速率得到：未估计其影响。
explain-stated-together = { $titles }在本记录中部分互相抵消：它们对各校准项目的影响合并说明，因为单独扣除其一会使数值偏移，而其余因素又将其抵回。
explain-items-not-estimated = 未能估计所发现因素对各校准项目的影响：{ $reason }

# 扣除所发现因素后的校准。
explain-adopted = 按规范计算之前，已从读数中扣除规范模型未包含的因素：{ $terms }。规范未规定此项处理。
explain-adopted-term = { $title } ({ $name })
explain-adopted-term-parameters = { $title } ({ $name }: { $parameters })
explain-adopted-information = 参考信息中的各量由原始读数得出，未经上述修正。
explain-adopted-alike = 本记录不能区分{ $term }与{ $others }；修正按前者进行。
explain-adopted-not-shown = 记录未显示高于噪声的{ $term }（ΔBIC { $bic }）；按指令仍予扣除。
explain-adopted-undetermined = 记录对{ $term }的{ $parameters }的确定程度不优于其自身大小：拟合其余参数时取为零，未作扣除；U 已包含其可能的大小。
explain-adopted-motion-unknown = 部分数据行的运动未知，未作扣除：{ $segments }。
explain-not-adopted-random = 未扣除{ $term }：其过程随机、无参数，不确定度无从给出；仍作为噪声留在读数中。
explain-budget-line = { $title }，{ $parameter }
