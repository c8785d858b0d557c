## 采集过程中发现的情况；$place 为文末三条之一。

station-unit-lost-samples = 被校对象的帧计数表明丢失 { $total } 个采样（{ $place }）。
station-unit-bad-frames = 被校对象有 { $total } 帧校验错误，已舍弃（{ $place }）。
station-encoder-gap = 缺少 { $total } 个转台编码器采样（{ $place }）。
station-air-temperature = 环境温度为 { $low }～{ $high } °C，超出校准程序允许的 { $limits } °C（{ $place }）。
station-air-humidity = 相对湿度为 { $low }～{ $high } %RH，超出校准程序允许的 { $limits } %RH（{ $place }）。
station-table-unsettled = 采集数据期间转台 { $subject } 轴未稳定（{ $place }）。
station-table-rate = 编码器表明转台 { $subject } 轴的角速率与给定值相差 { $low } %～{ $high } %（{ $place }）。
station-stuck-channel = 被校对象的 { $subject } 输出始终不变（{ $place }）。
station-spikes = 被校对象的 { $subject } 输出有 { $total } 个野值（{ $place }）。
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
station-virtual-fixture = 校准夹具（虚拟）
station-virtual-chamber = 温度试验箱（虚拟）

## 逐台设备试验的结果。

station-check-found = 与描述一致。
station-check-homed = 可以转动。
station-check-captured = 每 { $every } ms 一个采样，由转台锁存。
station-check-polled = 每 { $every } ms 一个采样，由查询得到，时刻误差不超过 ±{ $half_width } ms。
station-check-moved = 转动 { $angle }° 后返回，偏差不超过 { $within }″。
station-check-unit = { $rate } Hz，校验错误帧：{ $bad }；均值 { $means }。
station-check-serial = 被校对象自报编号 { $serial }；工位文件中为 { $named }。
station-check-state =
    { $axes }{ $count ->
        [0] 。
       *[other] ；报告 { $trips }。
    }
station-check-climate = { $values }。

## 采集日志：进入各状态的原因；$now 为测量段或步骤。

station-log-begun = 开始采集：{ $now }。
station-log-warming-up = 按校准程序预热。
station-log-measuring = { $now }，第 { $number } 段，共 { $count } 段：按校准程序进行。
station-log-repeating = { $now } 数据不可靠，重新测量。
station-log-paused = 操作人暂停采集（Ctrl-Z）。
station-log-turning-over = 在夹具上翻转被校对象：{ $now }。
station-log-finishing = 各段测量完毕，等待最后的数据。
station-log-done = 采集完成。
station-log-stopped = 采集中止：{ $cause }
station-log-given-up = 放弃该被校对象，采集继续进行：{ $cause }
station-log-operator = 操作人中止采集。
station-log-stopped-by = { $name }中止采集。
station-log-alarm = 发现：{ $alarm }。
station-log-times = { $alarm }（{ $count } 次）

station-alarm-unit-lost-samples = 被校对象丢失采样
station-alarm-unit-bad-frames = 被校对象有帧校验错误
station-alarm-encoder-gap = 转台编码器丢失采样
station-alarm-air-temperature = 环境温度超出校准程序范围
station-alarm-air-humidity = 相对湿度超出校准程序范围
station-alarm-table-unsettled = 采集数据期间转台 { $subject } 轴未稳定
station-alarm-table-rate = 转台 { $subject } 轴的角速率与给定值不符
station-alarm-stuck-channel = 被校对象的 { $subject } 输出不变
station-alarm-spikes = 被校对象的 { $subject } 输出有野值
station-page-stop = 停止
station-page-lockout = { $by } 停止后，任务一直等待。
station-page-release = 解除锁定：允许转动
station-page-left = 剩余时间
station-page-none = 尚无采集
station-page-at-rest = 停止 { $seconds } s 后，转台已静止。
station-page-not-confirmed = 未能确认转台静止，请按急停按钮。

## 工位人员对各类告警的处理方法。

station-todo =
    .unit-lost-samples = 检查被校对象的电缆与接头；若仍丢失采样，降低其输出频率或改用其他接口。
    .unit-bad-frames = 检查被校对象的电缆、屏蔽与接地，以及工位文件中的波特率。
    .encoder-gap = 检查转台控制器的网线，并确认没有其他程序在读取它。
    .air-temperature = 关好温箱，检查设定温度，等待温度回到校准程序范围内。
    .air-humidity = 检查室内空调或温箱的除湿装置，等待湿度回到校准程序范围内。
    .table-unsettled = 检查负载是否平衡、夹紧；若再次出现，请整定转台伺服。
    .table-rate = 不要使用本次测量；在测量下一个被校对象之前，请核查转台的角速率。
    .stuck-channel = 重新启动被校对象；若输出仍不变，则被校对象有故障：剔除。
    .spikes = 检查被校对象的接头、供电与夹紧；若仍有野值，则被校对象有故障：剔除。
    .given-up = 取下该被校对象，检查其电缆与供电；其余被校对象继续测量。之后重新下达任务。
station-of-unit = { $unit }: { $alarm }

## 采集或任务停止、失败或不能开始的原因（页面上显示）。

station-cause =
    .and = { $first }{ $rest }
    .other = 原因见日志。
    .other-unit = 已安装的被校对象是 { $found }，任务所定的是 { $ordered }：请安装 { $ordered }，或改为下达 { $found } 的任务。
    .no-serial = 被校对象 { $unit } 未报告编号：请检查供电与电缆。
    .busy = 工位 { $station } 正在进行另一次采集。
    .disk = 存放记录的磁盘剩余 { $free } GiB，一次采集可能需要 { $needed } GiB：请腾出空间。
    .catalogue = 目录数据库暂时不能使用。
    .locked-out = { $name } 停止了工位 { $station }：确认可以转动后，请在“产线”页面解除锁定。
    .no-worker = 本次采集的 Prefect 工作进程已丢失。
    .cancelled = 本次采集已在 Prefect 中取消。
    .not-written = 记录不能写入（{ $why }）。
    .during = 在“{ $now }”期间：{ $cause }
    .given-up = 放弃被校对象 { $unit }：{ $cause }
    .invalid = 本次采集无效：{ $reason }
    .silent = { $device } 处的设备无应答：请检查是否通电、连接。
    .nothing-sent = { $unit } 处的被校对象已有 { $seconds } s 未发送数据：请检查供电与电缆。
    .died = 执行进程意外终止。
    .no-frame = { $unit } 处的被校对象已有 { $seconds } s 只发送字节而无完整帧：请检查工位文件中的帧格式、波特率与电缆。
    .fault = 转台报告故障：在控制器上查看并排除，然后重新开始。
    .emergency-stop = 转台处于急停状态：确认安全后松开急停按钮，复位转台，然后重新开始。
    .interlock = 转台联锁断开：关好防护门，复位转台，然后重新开始。
    .watchdog = 转台过久未收到指令，已自行停止：检查网络，复位转台，然后重新开始。
    .not-settled = 转台轴 { $axis } 在 { $seconds } s 内未稳定：检查负载、平衡与伺服。
    .clock = 工位时钟停走或倒退，如同重新启动：重启控制器，然后重新开始。
    .line = 被校对象的线路 { $unit } 中断或不能打开：检查被校对象与电缆。
    .unit-restarted = { $unit } 处被校对象的时间倒退，如同重新启动：检查供电，然后重新开始。
    .no-home = 转台未找到零位：检查是否有轴被卡住。
    .fixture = 夹具未到达 { $turn }：查看是否被卡住。
    .still-turns = 已发出停止指令，转台仍在转动。
    .no-server = Prefect 服务器无应答：请确认其正在运行。

## 任务的结果，通知产线操作人员。

order-outcome =
    .failed = 任务 { $number }（工位 { $station }，被校对象 { $unit }）失败：{ $cause }处理：排除原因，然后在“操作”页“重新执行”或保留该任务。
    .refused = 任务 { $number }（工位 { $station }，被校对象 { $unit }）被拒绝：{ $cause }处理：更正后在“操作”页按“重新执行”。
    .waits = 任务 { $number }（工位 { $station }，被校对象 { $unit }）已 { $minutes } 分钟不能开始：{ $cause }
    .never-begun = 任务 { $number }（工位 { $station }，被校对象 { $unit }）一直没有开始：{ $cause }
    .nothing-takes-it = 没有进程接收该工位的任务。处理：请确认工位计算机及其工作进程正在运行。
