## 数字校准证书：仅在机器可读证书中出现的文字。

dcc-remark = { $remark }[{ $segments }]
dcc-record = 生成本证书所依据的记录
dcc-results = 校准结果
dcc-as-found = 调整前的校准结果
dcc-covariance = 全部校准值及其协方差
    .how = 以国际单位制单位按项目与元素列出 { $count } 个校准值，协方差为 A 类与 B 类分量之和。包含区域为椭球，其包含因子对应 { $count } 维向量，而非单个校准值。
dcc-information = 供参考的信息，不作判定
dcc-element = { $element }：{ $column }
dcc-field = { $label }：{ $value }
dcc-rates = { $axis } 轴角速率点（°/s）：{ $points }；共 { $count } 点
dcc-no-number = 未确定
dcc-chance = 合格概率 { $chance }
dcc-replaces = 代替 { $day } 的 { $number } 号证书
dcc-limit =
    .lower = 下限
    .upper = 上限
    .accept-lower = 接受下限
    .accept-upper = 接受上限
dcc-required = { $name }：{ $measured }；{ $by }：{ $required }
dcc-curves = 曲线
dcc-curve =
    .x = 横坐标
    .y = 纵坐标
