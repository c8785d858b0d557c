stamps-packets = 各行的时间戳是数据包到达的时刻（平均每 { $every } ms 到达 { $size } 个样本）。读数已置于 { $rate } Hz 的等间隔时刻，其标准不确定度为 { $u } ms；时间戳相对于这些时刻的散布为 { $most } ms，其平均延迟仍然保留。{ $missing ->
        [0] {""}
       *[other] 缺少 { $missing } 个样本。
    }
