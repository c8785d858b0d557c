## 超出部分所在之处。

locate-absorbed = 在运动已知处，已被规范模型全部吸收
locate-slight = 各占不足 5 %
locate-uniform = 各处相同
locate-intermittent = { $share } 出现在仅占总时间五分之一的若干短时段内
locate-settling = { $where }；时间常数 { $seconds } s
locate-concentrated = { $where }占 { $share }，而时间只占 { $time }
locate-variation = { $share } 随{ $variable }变化：{ $low } { $least }，{ $high } { $most }
locate-or = { $first }、{ $second }

locate-step = { $share } 为 { $time } s 处 { $step } 的阶跃
locate-after = { $share } 在 { $time } s 之后
locate-before = { $share } 在 { $time } s 之前
locate-frequency = { $share } 集中在 { $frequency } Hz
locate-harmonics = { $share } 为 { $axis } 轴每转 { $waves } 个周期的波
locate-one-wave = 1
locate-waves-1 = { $first }
locate-waves-2 = { $first }、{ $second }
locate-waves-3 = { $first }、{ $second }、{ $third }

locate-rate = 角速率
locate-rate-about = 绕 { $axis } 轴角速率
locate-rates = 角速率
locate-rates-about = 绕 { $axis } 轴角速率
locate-at-rate = { $rate } °/s 时
locate-at-rest = 静止时
locate-rates-one = { $rates }为 { $low } °/s 时
locate-rates-above = { $rates }为 不低于 { $low } °/s 时
locate-rates-below = { $rates }为 不高于 { $high } °/s 时
locate-rates-between = { $rates }为 { $low } 至 { $high } °/s 时

locate-attitude = 朝上的轴
locate-up = { $axis } 朝上时
locate-while-up = { $cells } 朝上时
locate-north = 北
    .heading = 姿态
locate-table-y = 转台 y
    .heading = 姿态
locate-up-and-to = { $up } 朝上且 { $level } 朝{ $towards }时
locate-gravity-changes = 重力方向是否改变
locate-gravity-fixed = 重力方向不变时
locate-gravity-changing = 重力方向改变时
locate-since-move = 距上次改变姿态的时间
locate-after-moves-within = 改变姿态后 { $high } s 内
locate-after-moves-between = 改变姿态后 { $low } s 至 { $high } s
locate-after-moves-later = 改变姿态 { $low } s 以后
locate-rate-changes = 角速率是否变化
locate-rate-steady = 角速率恒定时
locate-rate-changing = 角速率变化时

locate-time = 时间
locate-unit-temperature = 被校对象温度
locate-air-temperature = 环境温度
locate-air-humidity = 湿度
locate-air-supply_voltage = 电源电压
locate-air-pressure = 气压
locate-at-value = { $value } 时
locate-values-between = { $low } 至 { $high }
