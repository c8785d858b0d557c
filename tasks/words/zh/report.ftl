## explain 的答复：结论、各项发现与报告页面。

# 连接。句号写在各句之中。
report-sentence = { $text }。
report-sentences = { $first }{ $rest }
report-or = { $first }或{ $rest }

# 名称。
report-whole-certificate = 证书总结论

# 一项发现的叙述。
report-what = { $title }{ $given ->
        [0] {""}
       *[other] ：{ $sizes }{ $more ->
            [0] {""}
           *[other] ，另有 { $more } 个参数
        }（k = 2）
    }。
report-place = { $channel }（{ $share }）：{ $description }
report-places = 所在：{ $places }。
report-predicted = 未参与拟合的区段，其数据概率提高到 { $times }（{ $nats } nat）
report-not-predicted = 未参与拟合的区段预测未见改善（{ $nats } nat）
report-times = { $number } 倍
report-more-than-times = { $number } 倍以上
report-why = { $prediction }；ΔBIC = { $bic }：{ $evidence }（已计入参数个数）。
report-evidence-very-strong = 证据非常强
report-evidence-strong = 证据强
report-evidence-some = 有一定证据
report-evidence-none = 按此指标无证据
report-alternatives = 仅凭本次记录无法与以下效应区分：{ $effects }。
report-no-alternatives = 目录中没有其他效应能同样好地解释本次记录。
report-to-record = 如需确认，应补充记录：{ $recording }。
report-moves-most = 对证书影响最大的是：{ $element }，未计入时为 { $before }，计入后为 { $after }（k = 2），变化 { $times } U。
report-verdict-changes = { $item }的结论由“{ $before }”变为“{ $after }”。

# 结论。
report-no_mismatch = 未见失配
    .headline = 未见失配：规范模型足以说明本次记录
report-explained = 已查明
    .headline = 已查明：找到了规范模型所遗漏的物理因素
report-partly_explained = 部分查明
    .headline = 部分查明：找到了部分遗漏因素，其余尚无名称
report-unexplained = 未查明
    .headline = 未查明：模型与记录不符，目录中无任何效应可以解释
report-nothing-found = 未发现规范模型遗漏的物理因素。在未参与拟合的区段上，每自由度 χ² = { $chi2 }（仅有噪声时为 1）。小于噪声可分辨程度的效应，或被规范参数完全吸收的效应，本次记录无法显示。
report-tested = 检验了 { $channels } 个通道、{ $minutes } min、{ $rate } Hz 的数据{ $kinds ->
        [0] {""}
       *[other] ，含{ $segments }
    }。
report-static-segments = { $count } 个静止段
report-rate-segments = { $count } 个恒定角速率段
report-rotation-segments = { $count } 个定角转动段
report-detected = 与规范模型的最强偏离为 { $p }（已按检验次数修正）；p < { $limit } 时判为失配，无失配的记录约每 { $odds } 次有 1 次误报。
report-left-out = 规范模型遗漏了：{ $findings }。
report-left-out-size = { $title }（{ $size }）
report-unnamed = { $verdict ->
        [partly_explained] 其余部分失配
       *[unexplained] 模型与记录的差异
    }无法用目录中任何效应解释，故不予命名{ $described ->
        [0] {""}
       *[other] ；其变化规律：{ $follows }
    }。
report-gained = 在未参与拟合的区段上，每自由度 χ² 由 { $before } 变为 { $after }（仅有噪声时为 1）。
report-gained-most = 在未参与拟合的区段上，每自由度 χ² 由 { $before } 变为 { $after }（仅有噪声时为 1），{ $channel } 残差均方根降至 { $share }。
report-values-moved = 计入后，证书中有 { $values } 个值的变化超过 U。
report-values-and-verdicts-moved = 计入后，证书中有 { $values } 个值的变化超过 U，{ $verdicts } 项结论改变。

# 页面。
report-title = 模型与记录：{ $recording }
report-where = 所在位置
    .caption = 颜色表示规范模型的失配高出噪声多少倍标准差（取最显著的平均时间）。上方色带为静止、恒速与转动区段；各通道下方的短条为各项发现所在的区段，右侧数字为其占比。
    .caption-noise = 颜色表示规范模型的失配高出白噪声多少倍标准差（取最显著的平均时间）。个别浅色格为被校单元自身的慢变噪声，总体未超出偶然范围。
report-what-was-left-out = 遗漏的物理因素
report-before-after = 前后对比
    .caption = 左：残差随时间的分段平均，浅色条为段内的摆动。右：残差除以单次采样噪声后的频谱。
report-left-over = 剩余残差
    .caption = 左：残差随时间的分段平均。右：残差除以单次采样噪声后的频谱；低频处的上升为被校单元自身的闪烁噪声与漂移。
report-held-out = 未参与拟合的区段：每自由度 χ² 前 { $before }，后 { $after }（仅有噪声时为 1）。
report-rms-ratio = 残差均方根：后 / 前
report-certificate = 对证书的影响
report-nothing-moved = 未发现证书中有值受其影响。
report-remarks = 说明
report-method = 方法与误报率
    .compared = 以转台给出的运动和记录给出的重力驱动 JJF 2003—2022 模型(1)、(2)，与读数比较：不含地球自转、杆臂、基座倾斜、温度及延迟。逐一加入目录中的效应并重新联合拟合全部参数；加入的效应须能预测未参与其拟合的区段。
report-origin = 来源
    .recording = 记录
    .digest = 内容摘要（SHA-256）
    .model = 比较对象
    .unit = 被校单元
    .station = 校准台位
    .code = 程序版本
    .data = 数据

# 卡片与表格的标题。
report-card-size = 参数
report-card-follows = 变化规律
report-card-equation = 公式
report-card-why = 依据
report-card-alternatives = 其他可能
report-card-record = 如需确认，补充记录
report-card-certificate = 对证书的影响
report-column-number = 序号
report-column-parameter = 参数
report-column-value = 值
report-column-uncertainty = U（k = 2）
report-column-unit = 单位
report-column-channel = 通道
report-column-share = 占比
report-column-where = 位置
report-column-along = 维度
report-column-segments = 区段
report-column-element = 证书中的值
report-column-before = 未计入
report-column-after = 计入后
report-column-change = 变化 / U
report-change = { $before } → { $after }
report-column-verdict = 结论
report-dimension-rate = 角速率
report-dimension-attitude = 姿态
report-dimension-rotation_phase = 转动相位
report-dimension-frequency = 频率
report-dimension-temperature = 温度
report-dimension-time = 时间
report-dimension-after_moves = 运动之后
report-dimension-ramps = 加减速段
report-dimension-recorded = 已记录的环境量
report-dimension-level = 各处相同
