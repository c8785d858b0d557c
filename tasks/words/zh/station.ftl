## 采集过程中发现的情况；$place 为文末三条之一。

station-unit-lost-samples = 被校单元的帧计数表明丢失 { $total } 个采样（{ $place }）。
station-unit-bad-frames = 被校单元有 { $total } 帧校验错误，已舍弃（{ $place }）。
station-encoder-gap = 缺少 { $total } 个转台编码器采样（{ $place }）。
station-air-temperature = 环境温度为 { $low }～{ $high } ℃，超出规程允许的 { $limits } ℃（{ $place }）。
station-air-humidity = 相对湿度为 { $low }～{ $high } %RH，超出规程允许的 { $limits } %RH（{ $place }）。
station-table-unsettled = 采集数据期间转台 { $subject } 轴未稳定（{ $place }）。
station-table-rate = 编码器表明转台 { $subject } 轴的角速率与给定值相差 { $low } %～{ $high } %（{ $place }）。
station-stuck-channel = 被校单元的 { $subject } 输出始终不变（{ $place }）。
station-spikes = 被校单元的 { $subject } 输出有 { $total } 个野值（{ $place }）。
station-segment-repeated = { $subject } 段数据不可靠，已重新测量。

station-place =
    { $count ->
        [0] 不在测量段内
       *[other] { $more ->
            [0] { $names }
           *[other] { $names }等 { $count } 段
        }
    }

## 虚拟台站的设备。

station-virtual-turntable =
    { $axes ->
        [1] 单轴位置速率转台（虚拟）
       *[other] { $axes } 轴位置速率转台（虚拟）
    }
station-virtual-chamber = 温度试验箱（虚拟）

## 逐台设备试验的结果。

station-check-found = 与描述一致。
station-check-homed = 可以转动。
station-check-captured = 每 { $every } ms 一个采样，由转台锁存。
station-check-polled = 每 { $every } ms 一个采样，由查询得到，时刻误差不超过 ±{ $half_width } ms。
station-check-moved = 转动 { $angle }° 后返回，偏差不超过 { $within }″。
station-check-unit = { $rate } Hz，校验错误帧：{ $bad }；均值 { $means }。
station-check-state =
    { $axes }{ $count ->
        [0] 。
       *[other] ；报告 { $trips }。
    }
station-check-climate = { $values }。
