## 记录各段的检查。$segment：段名；$channel：器件数据列。

segments-position-contradicted = { $segment }：标注 { $label } 朝天，但 accel_{ $axis } 读数为 { $reading } m/s²：{ $shown ->
        [none] 无任何轴在读数 10° 以内，未取用
       *[other] 重力显示 { $shown } 朝天，已按重力取用
    }。
segments-rate-contradicted = { $segment }：标注绕 { $axis } 轴 { $label } °/s，但{ $witness ->
        [table] 转台
       *[other] { $witness }
    }显示 { $shown } °/s：{ $witness ->
        [table] 已按转台速率取用
       *[other] 未取用
    }。
segments-unsteady-rate = { $segment }：{ $witness ->
        [table] 转台
       *[other] { $witness }
    }显示该段内角速率变化 { $wander } °/s；{ $clause } 要求角速率平稳（{ $percent }%）。
segments-corrupted-rows = { $segment }：{ $rows } 行中有 { $out } 行远离其余数据（{ $channels }），未计入均值。
segments-disturbed = { $segment }：{ $rows } 行中有 { $out } 行远离其余数据（{ $channels }），未计入均值；其中连续 { $burst } 行：该段受到扰动。
segments-stuck = { $segment }：{ $channel } 自 t = { $time } s 起连续 { $rows } 行停在 { $value }。
segments-lost-samples = { $segment }：{ $gaps } 处间断共丢失 { $lost } 个采样，最长 { $longest } s，位于 t = { $time } s。
segments-short-dwell = { $held } 段中有 { $short } 段短于 { $clause } 要求的每点 { $asked } s：{ $listed }。
segments-coarse-step = 输出分辨力大于噪声（{ $steps }，SI 单位）：平均不能消除，均值可能偏离半个分度。
segments-overlapping-segments = 标注段相互重叠，同一数据被重复计入：{ $more ->
        [0] { $pairs }
       *[other] { $pairs }等，另有 { $more } 对
    }。
segments-pair = { $first } 与 { $second }
segments-environment = { $segment }：{ $quantity ->
        [temperature] 环境温度
       *[humidity] 相对湿度
    } { $worst } { $unit } 超出 { $low }~{ $high } { $unit }（{ $clause }）。
segments-environment-not-recorded = 未同时记录环境温度和湿度：无法确认是否满足 { $clause } 的环境条件。
segments-without-rows = { $count } 个标注段的数据行过少，未取用：{ $listed }。
segments-null-rows = { $count } 段因含空值行，未取用其 { $triad } 数据：{ $listed }。
segments-table-gap = 转台数据未覆盖 { $count } 段，其姿态和角速率仅由标注得到：{ $gaps }。
segments-table-gap-from = { $segment } 自 t = { $time } s 起
