## explain 的答复：结论、各项发现与报告页面。

# 连接。句号写在各句之中。
report-sentence = { $text }。
report-sentences = { $first }{ $rest }
report-or = { $first }或{ $rest }
report-one-of = { $effects }（本次记录不能区分）

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
report-parameter = { $name } = { $size }
report-factor = { $channel } 的第 { $number } 个系数
parameter-seconds = 单元相对参考装置的滞后（负值：参考装置滞后）
parameter-of-rms = { $channel }在本次运行内的均方根
parameter-of-rate = { $channel }的游走系数
report-place = { $channel }（{ $share }）：{ $description }
report-places = 所在：{ $places }。
report-predicted = 未参与拟合的区段，其数据概率提高到 { $times }（{ $nats } nat）
report-not-predicted = 未参与拟合的区段预测未见改善（{ $nats } nat）
report-times = { $number } 倍
report-more-than-times = { $number } 倍以上
report-why = 其消除了高出噪声的失配的 { $share }。{ $prediction }；ΔBIC = { $bic }：{ $evidence }（已计入参数个数）。
report-why-over-many = 其量值过小或过于罕见，在单次读数的失配中占不到可计的份额；只有把全部读数合在一起才显现。{ $prediction }；ΔBIC = { $bic }：{ $evidence }（已计入参数个数）。
report-why-absorbed = 规范模型的参数已将其全部吸收：它体现在参数值中，而不在剩余残差中。ΔBIC = { $bic }：{ $evidence }（已计入参数个数）。
report-nothing-removes = 目录中的效应和所查找的规律均不能消除它；各通道剩余的每自由度 χ²（以静止噪声与参考的噪声为 1）：{ $channels }。
report-evidence-very-strong = 证据非常强
report-evidence-strong = 证据强
report-evidence-some = 有一定证据
report-evidence-none = 按此指标无证据
report-stays-high = 但计入后，{ $channel } 的每自由度 χ² 仍为 { $chi2 }（以静止噪声与参考的噪声为 1）：该处尚有其他遗漏，或参考的精细程度仅止于此。证据与 U 均相对于剩余残差计算；查明其他遗漏后，其大小可能改变。
report-homogeneity = 其参数在记录的各独立部分之间{ $alike ->
        [0] 的差异超出偶然（{ $p }）{ $named ->
            [0] ：并无处处成立的同一规律，U 已包含该分散性
           *[1] ，但不足以否定该名称；U 已包含该分散性
        }
       *[1] 一致（{ $p }）
    }。
report-group = 在本次记录中以下效应可相互替代，其中任何一个都能在剩余残差范围内拟合：{ $effects }{ $shared ->
        [0] {""}
       *[other] 。它们的共同部分为 { $common }（k = 2）
    }。
report-alternatives = 仅凭本次记录无法与以下效应区分：{ $effects }。
report-no-alternatives = 目录中已试验的其他效应均不能同样好地解释本次记录。
report-to-record = 如需确认，应补充记录：{ $recording }。
report-moves-most = { $joint ->
        [0] {""}
       *[other] 与发现 { $others } 合计，
    }对证书影响最大的是：{ $element }，未计入时为 { $before }，计入后为 { $after }（± U），变化 { $times } U（取两者中较大者）。
report-moves-in-set = { $joint ->
        [0] 单独计入时，
       *[other] 与发现 { $others } 合计，
    }证书中的一个值（{ $element }）变化 { $times } U，但被其他发现抵消：全部计入后变化 { $together } U，应以此为准。
report-to-do = 下一步：{ $next }。
report-verdict-changes = { $item }的结论由“{ $before }”变为“{ $after }”。

# 不予命名的发现。
report-without-name = 未命名：{ $pattern }
report-pattern = { $pattern }，通道：{ $channels }
report-refused-implausible = 若视为“{ $effect }”，其 { $parameter } 将为 { $value }，{ $larger ->
        [0] 超出正常产品或转台的限值 { $limit }
       *[1] 是任何正常产品或转台的 { $times } 倍（限值 { $limit }）
    }，故不予此名；这样的量值通常意味着{ $usual }。
report-usual = { $kind ->
        [time] 时间戳单位有误（ms 误作 s），或两路数据并非同时记录
        [length] 长度单位有误（mm 误作 m），或坐标轴互换、反向
        [angle] 给定姿态有误、度与弧度混淆，或坐标轴互换、反向
        [alike] 另有表现相似的原因
       *[scale] 量程或单位设置有误（度与弧度、g 与 m/s²、每单位计数），或坐标轴互换、反向
    }
report-refused-inhomogeneous = 其表现类似“{ $effect }”，但大小并非处处相同：{ $parameter } { $parts ->
        [rate] 在小角速率与大角速率之间
        [up] 随朝上的轴不同
        [triad] 在陀螺与加速度计之间
        [axis] 在各轴之间
       *[time] 在试验过程中
    }由 { $smallest } 变到 { $largest }，不符合同一规律，故不予此名。
report-refused-channel = 其表现类似“{ $effect }”，但该效应同样应影响的 { $channel } 计入后预测反而变差，故不予此名。
report-refused-undetermined = 其表现类似“{ $effect }”，但没有一个参数大于其 U（{ $parameter } = { $value }，U = { $limit }）：本次记录不能确定该效应。
report-refused-reference-noise = 其表现类似“{ $effect }”，但参考装置自身的误差即可造成同样大小的变化，故不予此名。
report-refused-placed = 其表现类似“{ $effect }”，但产品的姿态仅由标注给出，而 { $placed } 个静止位置所余的数据个数不多于该效应的参数个数：摆放误差也会呈现同样的结果，故不予此名。
report-refused-switching = 其表现类似“{ $effect }”，但其变化几乎全部发生在两个时刻，而随机游走应始终在变化：来回切换的信号会呈现同样的结果，故不予此名。
report-refused-overshadowed = 其表现类似“{ $effect }”，但相应通道中仍有未得到解释的部分（每自由度 χ² 最大为 { $chi2 }，为它所消除部分的 { $times } 倍），很可能包含了它，因此不以此命名。
report-refused-form-error = 其表现类似“{ $effect }”，但其他发现的分量是它的{ $times }倍，其方程的形式稍有差异即可留下同样的残余，故不予此名。

# 下一步。
report-next-implausible = 检查是否存在：{ $usual }；更正后重新解释
report-next-alike = 检查产品与参考之间的连接是否刚性（工装、轴、联轴器）、输出之前有何滤波、参考本身是否正确；再以一半和两倍的速度记录同样的运动
report-next-inhomogeneous = { $parts ->
        [rate] 以三个以上的速率记录同样的运动：其大小随角速率的变化可说明是哪种物理因素
        [up] 在各轴朝上时重复该运动，并检查姿态改变时的安装与电缆
        [triad] 比较陀螺与加速度计的滤波与时间戳：输出率、低通与时标
        [axis] 比较各轴的设置：量程、滤波、采样次序及安装
       *[time] 查看试验日志中的变化（设置、温度、安装），并在试验末尾重复其开始部分
    }
report-next-channel = 检查{ $channel } 的符号、标度与滤波，并绕另一轴记录同样的运动
report-next-undetermined = 补充能确定它的记录：{ $recording }
report-next-reference-noise = 换用分辨力更高或噪声更小的编码器重做试验：目前编码器的噪声掩盖了产品的表现
report-next-placed = 将产品再次放置到每个位置，或记录其姿态（编码器、位姿跟踪）：随姿态重复出现者为规律，不重复者为摆放误差
report-next-switching = 查明这些时刻接通、断开或触碰了什么，并记录数小时的静止数据：来回切换者有两个电平，随机游走则没有
report-next-overshadowed = 先查明这些通道中剩余失配的原因，然后重新分析
report-next = { $dimension ->
        [rate] 在正反两个方向各取不少于五个恒定角速率，观察剩余残差是随角速率、其大小还是其平方增长
        [attitude] 在两个航向上记录各轴朝上、朝下及45°的静止位置，并检查随姿态变化的因素：电缆、夹紧、附近的磁体
        [rotation_phase] 产品在台面两个位置上，正反向慢速转整周：在轴上位置不变的属于转台
        [frequency] 分别在驱动开启与关闭时记录静止数据，并改变采样率再记录一次：随驱动停止的为振动，频率移动的为混叠
        [temperature] 在三个稳定温度下记录静止数据，升温、降温各一次
        [time] 查看日志中该时刻发生了什么，并重复试验：不在同一时刻再现的与运动无关
        [after_moves] 将每次静止时间延长至五倍，从两个方向到达，并观察工装的稳定过程
        [ramps] 以三种角加速度记录加减速段，两套时钟共用触发信号，并查明产品输出的滤波与时间戳方式
        [recorded] 产品静止时单独改变该环境量
       *[level] 记录一段静止数据，并以一半和两倍的速度重复同一运动：静止时存在的为噪声或漂移，随速度增大的为对运动的响应
    }

# 结论。
report-summary = { $kinds ->
        [none] 高出噪声的失配均未能命名：其中 { $unnamed } 有规律可循，但目录中无任何效应可以解释，{ $left } 无规律可循
        [some] 高出噪声的失配中，{ $all } 已得到说明（{ $named } 为已命名的效应，{ $unnamed } 为未命名的规律），{ $left } 未得到说明
        [absorbed] 残差未高出噪声：遗漏的物理因素已被规范模型的参数全部吸收
       *[all] 高出噪声的失配中，{ $all } 已得到解释，{ $left } 未得到解释
    }；首先应检查：{ $first }。
report-first-left = { $channel } 的剩余残差（每自由度 χ² = { $chi2 }）
report-left = 剩余残差仍高出产品噪声与参考噪声的通道及其每自由度 χ²：{ $channels }。
report-left-in = { $channel } { $chi2 }
report-small = 微小的剩余因素：{ $remainders }。
report-small-finding = { $title }（{ $share }）
report-no_mismatch = 未见失配
    .headline = 未见失配：规范模型足以说明本次记录
report-explained = 已查明
    .headline = 已查明：找到了规范模型所遗漏的物理因素
report-partly_explained = 部分查明
    .headline = 部分查明：找到了部分遗漏因素，其余尚无名称
report-unexplained = 未查明
    .headline = 未查明：模型与记录不符，目录中无任何效应可以解释
report-invalid = 按导入的内容，本次运行无效：
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
report-left-out-or = { $title }，或 { $others }（本次记录无法区分）
report-unnamed = { $verdict ->
        [partly_explained] 其余部分失配
       *[unexplained] 模型与记录的差异
    }无法用目录中任何效应解释，故不予命名{ $described ->
        [0] {""}
       *[other] ；其表现：{ $follows }
    }。
report-gained = 在未参与拟合的区段上，每自由度 χ² { $change ->
        [level] 为 { $after }
        [rises] 由 { $before } 升至 { $after }
       *[falls] 由 { $before } 降至 { $after }
    }（以残差的高频噪声为 1）{ $most ->
        [0] {""}
       *[other] ，{ $channel } 残差均方根降至 { $share }
    }。
report-moved = { $findings ->
        [one] 计入后
       *[other] 全部发现一并计入后
    }，证书中有 { $values } 个值的变化超过 U（取两者中较大者）{ $verdicts ->
        [0] {""}
       *[other] ，{ $verdicts } 项结论改变
    }，变化最大的是{ $element }：{ $before } → { $after }（{ $times } U）。

# 页面。
report-title = 模型与记录：{ $recording }
report-shares =
    .caption = 左：各项发现所消除的、高出噪声的失配的份额，以及未得到解释的部分。右：各通道剩余残差的每自由度 χ²，以产品与参考的噪声为准（仅有噪声时为 1）。
report-where = 所在位置
    .caption = 颜色表示规范模型的失配高出噪声多少倍标准差（取最显著的平均时间）。上方色带为静止、恒速与转动区段；各通道下方的短条为各项发现所在的区段，右侧数字为其占比。
    .caption-noise = 颜色表示规范模型的失配高出白噪声多少倍标准差（取最显著的平均时间）。个别浅色格为被校对象自身的慢变噪声，总体未超出偶然范围。
report-what-was-left-out = 遗漏的物理因素
report-before-after = 前后对比
    .caption = 左：残差随时间的分段平均，浅色条为段内的摆动。右：残差除以单次采样噪声后的频谱。
report-left-over = 剩余残差
    .caption = 左：残差随时间的分段平均。右：残差除以单次采样噪声后的频谱；低频处的上升为被校对象自身的闪烁噪声与漂移。
report-held-out = 未参与拟合的区段：每自由度 χ² 前 { $before }，后 { $after }（以残差的高频噪声为 1）。
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
    .unit = 被校对象
    .station = 校准台位
    .code = 程序版本
    .data = 数据

# 卡片与表格的标题。
report-card-size = 参数
report-card-refused = 不予命名的原因
report-card-equation = 公式
report-card-why = 依据
report-card-tests = 其他检验
report-card-alternatives = 其他可能
report-card-record = 如需确认，补充记录
report-card-certificate = 对证书的影响
report-card-next = 下一步
report-together = 合计
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
report-column-expanded = U
report-column-change = 变化 / 较大的 U
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

# 报告插图中的文字。
chart-time = 时间 / { $unit }
chart-frequency = 频率 / Hz
chart-none = 无
chart-not-known = 未知
chart-excess = 超出噪声
chart-where = 标准模型与记录不符之处
    .title = 六个通道超出噪声的部分随时间的分布
chart-segments =
    .static = 静止
    .rate = 速率
    .rotation = 转动
chart-kinds =
    .static = 静止
    .rate = 速率
    .rotation = 转动
chart-shares = 在超出噪声的差异中所占份额
    .title = 各项发现的份额与剩余部分
chart-not-explained = 未解释
chart-left-over = 剩余：每自由度 χ²
chart-noise-alone = 仅噪声：1
chart-residual = 剩余残差：读数 − 模型
    .title = 计入前后的残差
chart-spectrum = 其频谱，白噪声 = 1
chart-lines =
    .model = 标准模型
    .before = 计入前：标准模型
    .after = 计入后：含所发现效应
    .noise = 均值的噪声，±2σ
