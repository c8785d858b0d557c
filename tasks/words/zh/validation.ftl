## The validation record, and what the gate makes of it.

validation-stale = 本版本的 { $method } 估计方法未经验证
validation-failed = 本版本的 { $item } 估计未经验证（{ $evidence } 未通过）
    .element = { $item } 的 { $elements } 的估计未经验证：仿真单元中其 95 % 区间包含真值的比例低于 { $low } %
validation-none = 无适用于本版本的估计验证记录
validation-record = 估计方法经验证，记录 { $record }：{ $items } 项中 { $valid } 项通过
    .in-part = 估计方法经验证，记录 { $record }：{ $items } 项中 { $valid } 项全部通过；未经验证：{ $elements }
validation-within = 本次测量的条件属于经验证的情形：{ $scenarios }
    .none = 本次测量的条件（{ $conditions }）不属于任何经验证的情形
    .list = { $first }、{ $rest }
validation-scenario = { $name ->
    [mount] 给出的安装姿态不正交
    [labels] 仅有标注并给出其速率的误差极限
    [labels-mount] 仅有标注且给出的安装姿态不正交
    [polled] 编码器为轮询读取并给出其时刻的误差
    [one-heading] 各位置仅一个航向
    [few-rates] 速率点少
    [flicker] 数小时内仍为 1/f 的噪声
    [warming] 被校对象升温
    [drift] 零位漂移
    [coarse-steps] 分辨力掩盖噪声
    [base] 基面的倾斜
   *[in-order] 一切正常
}
validation-elements = { $item } { $elements }
validation-coverage = { $units } 台仿真单元的 { $values } 个值中，{ $share } 位于所给 95 % 区间内；目标为至少 { $fewest } 台、{ $low } %～{ $high } %
    .too-long = { $units } 台仿真单元的 { $values } 个值中，{ $share } 位于所给 95 % 区间内；目标为至少 { $fewest } 台、{ $low } %～{ $high } %；不确定度偏大
validation-example = { $specification } 附录 A（{ $clause }）：u_c = { $u_c }，U = { $U }；本程序：{ $result }
validation-independent = 与独立最小二乘相差 { $values } u（允许 { $limit } u）；与 GTC 的不确定度预算相差 { $budgets }（允许 { $close }）
validation-recovery = 理想测量恢复真值，最大偏差 { $error } { $unit }；要求 { $close }
