## 事件：读数中的异常，用于结论与附注。

events-saturation = { $sensors }输出止于 { $limit }：有 { $count } 个读数停在该处，无一超出
events-plateau = { $sensors }的读数停留不动，而预测值继续增大：{ $limits }
events-plateau-at = { $channel }停在 { $limit }（{ $count } 个读数应超出）
events-quantisation = { $sensors }的步距为 { $step }，是噪声的 { $ratio } 倍
events-code-fault = 编码有误：{ $channels }
events-code-fault-at = { $channel }有 { $share } % 的读数偏离 { $codes } 个编码（{ $jump }）的整数倍，是否偏离由编码决定
events-lost-samples = 样本丢失，其后的时间戳随之滑移：{ $losses }
events-lost-samples-at = { $time } s 处 { $lost } 个
events-gaps = 时间戳有 { $gaps } 处间断，共缺 { $missing } 个采样间隔；其余时间戳正确，故不属模型不符
events-spikes = { $count } 个孤立读数偏离相邻读数超过噪声的 { $threshold } 倍，通道：{ $channels }
events-spikes-in-rotation = { events-spikes }，仅在转台转动时出现
events-mains = 工频干扰 { $frequency } Hz，出现在 { $lines }，通道：{ $channels }
events-line = { $frequency } Hz 处有一条始终存在的谱线，通道：{ $channels }
events-impacts = 外轴每转 { $per_turn } 次的撞击，通道：{ $channels }
events-bursts = { $count } 次 { $frequency } Hz 的突发振荡，衰减时间 { $decay } s，通道：{ $channels }，时刻 { $times } s
events-range = { $sensors }的读数是应有值的 { $factor } 倍：{ $cause }
events-range-counts = 每单位计数或量程设置错误
events-range-power-of-two = 量程设置相差 2 的整数次幂
events-range-degrees = 应为弧度处用了度
events-range-radians = 把弧度当作度换算
events-range-gravities = 应为 m/s² 处用了 g
events-range-metric = 把 m/s² 当作 g 换算
events-range-thousand = 应为整单位处用了千分之一单位，或相反
events-axis-mapping = { $sensors }的轴互换或反向：{ $axes }
events-axis-reads = { $channel }读的是 { $sign }{ $axis }
