# 固件对输出编码的处理错误
codes-signed-low = 低字节按有符号数相加
codes-signed-low-or = 低字节按有符号数作或运算，高字节被抹去
codes-bytes = 字节顺序颠倒
codes-unsigned = 补码被读作无符号数
codes-wrap = 满量程处回绕，周期为 { $size }
codes-stuck-high = 有一位恒为 1
codes-stuck-low = 有一位恒为 0
codes-size = { $codes } 个编码
codes-jump = { $jump }
codes-suspected = { $channel }的读数有约 { $size }的跳变，疑为：{ $bug }；但敲击或冲击留下的痕迹与此相近，故未作改动。缓慢转过跳变处或在其外静置的记录可作判定。
codes-torn = 高字节为上一行的值

# 读数经修正后的结果
validity-codes-put-right = { $channels } 的输出编码有误，已在计算前逐一准确改正：{ $bug }，各通道至多 { $share } % 的读数偏离 { $size }的整数倍。原始记录未作改动；请修正固件。
validity-codes-undecided = { $channels } 的输出编码有误，无法逐一改正：{ $bug }，读数偏离 { $size }的整数倍{ $segments ->
        [0] {""}
       *[other] （有 { $segments } 段不能确定）
    }。请修正固件后重新测量。
