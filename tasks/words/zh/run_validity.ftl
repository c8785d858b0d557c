## 记录各段的检查。$segment：段名；$channel：被校对象数据列。

validity-position-contradicted = { $segment }：标注 { $label } 朝天，但 accel_{ $axis } 读数为 { $reading } m/s²：{ $shown ->
        [none] 无任何轴在读数 10° 以内，未取用
       *[other] 重力显示 { $shown } 朝天，已按重力取用
    }。
validity-rate-contradicted = { $segment }：标注绕 { $axis } 轴 { $label } °/s，但{ $witness ->
        [table] 转台
       *[other] { $witness }
    }显示 { $shown } °/s：{ $witness ->
        [table] 已按转台速率取用
       *[other] 未取用
    }。
validity-unsteady-rate = { $segment }：{ $witness ->
        [table] 转台
       *[other] { $witness }
    }显示该段内角速率变化 { $wander } °/s；{ $clause } 要求角速率平稳（{ $percent } %）。
validity-corrupted-rows = { $segment }：{ $rows } 行中有 { $out } 行远离其余数据（{ $channels }），未计入均值。
validity-disturbed = { $segment }：{ $rows } 行中有 { $out } 行远离其余数据（{ $channels }），未计入均值；其中连续 { $burst } 行：该段受到扰动。
validity-stuck = { $segment }：{ $channel } 自 t = { $time } s 起连续 { $rows } 行停在 { $value }。
validity-lost-samples = { $segment }：{ $gaps } 处间断共丢失 { $lost } 个采样，最长 { $longest } s，位于 t = { $time } s。
validity-short-dwell = { $held } 段中有 { $short } 段短于 { $clause } 要求的每点 { $asked } s：{ $listed }。
validity-coarse-step = 输出分辨力大于噪声（{ $steps }，陀螺为 rad/s，加速度计为 m/s²）：平均不能消除，均值可能偏离半个分度。
validity-overlapping-segments = 标注段相互重叠，同一数据被重复计入：{ $more ->
        [0] { $pairs }
       *[other] { $pairs }等，另有 { $more } 对
    }。
validity-pair = { $first } 与 { $second }
validity-environment = { $segment }：{ $quantity ->
        [temperature] 环境温度
       *[humidity] 相对湿度
    } { $worst } { $unit } 超出 { $low }~{ $high } { $unit }（{ $clause }）。
validity-environment-not-recorded = 未同时记录环境温度和湿度：无法确认是否满足 { $clause } 的环境条件。
validity-without-rows = { $count } 个标注段的数据行过少，未取用：{ $listed }。
validity-null-rows = { $count } 段因含空值行，未取用其 { $triad } 数据：{ $listed }。
validity-table-gap = 转台数据未覆盖 { $count } 段，其姿态和角速率仅由标注得到：{ $gaps }。
validity-table-gap-from = { $segment } 自 t = { $time } s 起

## 整个测量过程的检查。

validity-no-reference = 未记录编码器或位姿：{ $count } 段转动的角速率仅由标注得到。
validity-angle-contradicted = { $segment }：标注转角 { $label }°，但编码器显示转过 { $shown }°。
validity-rest-turns = { $count } 个静止段并非静止（首个为 { $first }）：转台在转动，或陀螺读数与其余静止段不符。
validity-encoder-jump = { $axis } 轴编码器跳变 { $count } 次，最大 { $size }°，位于 t = { $time } s，转台不可能如此转动。
validity-attitude-contradicted = { $count } 个静止段（首个为 { $first }）中重力方向与编码器不符，最大相差 { $left } m/s²，允许 { $limit } m/s²。
validity-gyro-contradicts-encoder = 绕 { $axis } 轴的 { $count } 段（首个为 { $first }）中，陀螺对编码器的响应与其余各段相差超过 { $percent } %。
validity-input-axis = 绕 { $axis } 轴转动的各段中，跟随转速的是陀螺 { $gyro }，响应为 { $gain } 倍：被校对象的安装与记录说明不符，或其通道、符号被改变。
validity-latitude-not-given = 未给出纬度：无法据此核对重力和地球自转。
validity-laboratory-latitude = 记录给出的纬度为 { $latitude }°，而实验室位于 { $own }°。
validity-gravity-not-given = 未给出当地重力加速度。
validity-gravity-contradicted = 给出的当地重力加速度为 { $gravity } m/s²，但纬度 { $latitude }°、海拔 { $lowest }~{ $highest } m 处应为 { $low }~{ $high } m/s²。
validity-earth-not-shown = 静止数据未显示地球自转的水平分量：北向 { $north }、东向 { $east }（u = { $u }，以地球自转角速率为单位），而纬度 { $latitude }° 处北向应为 { $expected }；纬度或方位可能有误，或数据已经补偿。
validity-earth-contradicted = 静止数据显示的地球自转与纬度、方位不符：北向 { $north }、东向 { $east }（u = { $u }，以地球自转角速率为单位），而纬度 { $latitude }° 处北向应为 { $expected }。
validity-latitude-sign = 静止数据显示地球自转的天向分量为 { $shown }（u = { $u }，以地球自转角速率为单位），而纬度 { $latitude }° 处应为 { $expected }：纬度符号有误。
validity-samples-off = { $channel }：{ $share } % 的采样偏离所在段其余数据超过 { $off } 倍标准差，允许 { $limit } %。
validity-vibration = { $channel }：{ $count } 个静止段（首个为 { $first }）中读数的标准差达 { $deviation }，允许 { $limit }（陀螺为 rad/s，加速度计为 m/s²）：被校对象受到振动。
validity-drift = { $channel }：{ $segment } 与其余静止段相差 { $left } { $unit }，U = { $U } { $unit } 未能涵盖：零位漂移或跳变。
validity-unsteady-zero = { $channel }：{ $segment } 与其余静止段相差 { $left }，允许 { $limit }（陀螺为 rad/s，加速度计为 m/s²）：零位漂移或跳变。
validity-lost-share = 各段中 { $stream } 数据流缺少 { $share } % 的采样，允许 { $limit } %。
validity-time-base = 按记录的时间，{ $count } 个速率点的转台速率均与设定值相差 { $off }×10⁻⁶，允许 { $limit }×10⁻⁶：请检查记录读数的时钟或转台的时钟。
validity-clocks-apart = 被校对象与转台的时间最多相差 { $delay } s，允许 { $limit } s。
validity-environment-in-part = { $quantity ->
        [temperature] 环境温度
       *[humidity] 相对湿度
    }：{ $of } 段中有 { $count } 段未记录（首个为 { $first }），无法确认是否满足 { $clause }。
validity-unit-temperature-not-recorded = { $of } 段中有 { $count } 段未记录被校对象自身温度。
validity-follows-temperature = { $channel } 随所记录的被校对象温度变化（变化 { $change } K）：增益 { $gain } ppm/K，零位每 K { $zero } { $unit }。各测得值对应其旁所给的温度。
validity-unit-temperature-changed = 测量期间被校对象自身温度由 { $low } °C 变至 { $high } °C，允许变化 { $limit } K。
validity-unit-temperature-level = 被校对象自身温度为 { $level } °C，环境温度为 { $air } °C；允许比环境低 { $cooler } K 至高 { $warmer } K。
validity-supply-not-recorded = { $of } 段中有 { $count } 段未记录被校对象的供电电压。
validity-supply-level = 被校对象的供电电压为 { $level } V；所需电压应为 { $low }~{ $high } V。
validity-supply-changed = 被校对象的供电电压在 { $low }~{ $high } V 间变化，通常为 { $usual } V，允许 ±{ $percent } %。
validity-beyond-recording = { $segment } 标注为 { $start } 至 { $end } s，而采样仅为 { $first } 至 { $last } s：标注时刻有误，或记录不完整。
validity-misspelt-field = manifest 中的字段 { $field } 无法识别，未予使用；字段 { $meant } 缺失：如系笔误，请改正。
validity-station-remarks-unreadable = 无法读取台站记录的情况（manifest 的 { $field } 字段）。
