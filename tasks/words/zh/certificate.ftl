## The certificate: texts, by specification and method where they differ, and labels.

certificate-title =
    .virtual = { $title }（虚拟，仅为仿真）
    .calibration = 校准证书
    .report = 校准报告
    .invalid-run = 测量无效报告
certificate-not-given = 未提供
certificate-quoted = { $text }
certificate-watermark =
    .virtual = 虚拟
    .draft = 草稿
    .checked = 未签发
    .amended = 已更改
    .withdrawn = 已撤销
certificate-field =
    .client = 送校单位
    .client-address = 送校单位地址
    .object = 被校对象名称
    .manufacturer = 制造厂
    .model = 型号规格
    .serial = 编号
    .specification = 校准规范
    .received = 接收日期
    .place = 校准地点
    .accreditation = 认可信息
    .contact = 实验室联系方式
    .condition = 被校对象状态
    .rate-range = 角速率量程
    .accel-range = 比力量程
    .output-rate = 输出频率
    .bandwidth = 带宽
    .firmware = 固件版本
    .adjustment = 调整情况
    .sampling = 抽样
    .calibrated = 校准日期
    .report = 报告类型
    .replaces = 代替证书
    .due = 建议复校日期
    .as-found = 调整前结论
    .dwell = 采样时间（最短）
    .positions = 静止位置
    .zero-positions = 零偏位置
    .turns = 整周转动
    .attitudes = 安装姿态四元数（w, x, y, z）
    .mounting = 安装位置
    .limits-from = 判定依据
    .rule = 判定规则
    .rule-number = 判定规则 { $number }
    .risk = 误判风险
    .global-risk = 总体误判风险
    .marks = 记号
    .verdict = 结论
    .recording = 记录
    .run = 测量
    .digest = 原始数据摘要
    .method = 计算方法
    .procedure = 校准程序
    .code-version = 软件版本
    .settings = 设置
    .station = 校准装置
    .gravity = 当地重力
    .latitude = 纬度
certificate-role =
    .operator = 校准员
    .checker = 核验员
    .issuer = 签发人
certificate-not-issued = 尚未签发
certificate-step-open =
    .check = 尚未核验
    .issue = 尚未签发
certificate-no-statement = 未作符合性判定
certificate-due-from-issue = { $day }（未提供校准日期，自证书日期起算）
certificate-replaced = { $day } 签发的 { $number }，原因：{ $why }
certificate-scope =
    .pass =
        { $items } 项中 { $limited } 项有允许限，{ $limited ->
            [1] 合格
           *[other] 均合格
        }
    .fail = { $items } 项中 { $limited } 项有允许限，判定 { $decided } 项，其中 { $failed } 项不合格
    .inconclusive =
        { $items } 项中 { $limited } 项有允许限，{ $decided ->
            [0] 均未能判定
           *[other] 其中 { $decided } 项已判定
        }
    .in-part = { $scope }；其中 { $count } 项仅部分元素有允许限
    .near = { $scope }；其中 { $count } 项有测得值距允许限小于 U
    .as-found = { $scope }；调整前：{ $verdict }
certificate-environment =
    .temperature = 环境温度
    .humidity = 相对湿度

## By specification and method

certificate-object =
    .jjf-2003-2022 = 微惯性测量组合（MIMU）
    .jjf-1536-2015 = 捷联式惯性航姿仪
certificate-specification =
    .jjf-2003-2022 = JJF 2003—2022《微惯性测量组合（MIMU）校准规范》
    .jjf-1536-2015 = JJF 1536—2015《捷联式惯性航姿仪校准规范》
certificate-followed =
    .jjf2003 = JJF 2003—2022
    .jjf2003-deviating = 参照 JJF 2003—2022，有偏离，见“说明”
    .joint = 参照 JJF 2003—2022
    .joint-deviating = 参照 JJF 2003—2022，有偏离，见“说明”
    .jjf1536 = JJF 1536—2015
    .jjf1536-deviating = 参照 JJF 1536—2015，有偏离，见“说明”
certificate-setting =
    .gravity-m-s2 = 所用重力加速度
    .latitude-deg = 所用纬度
    .uncertainty = 不确定度
    .limits = 校准装置的极限
    .u1-of-the-table = 转台的 u1
    .effective-bits = 有效位数
    .axes = 结果所依据的轴线
    .mount = 被校对象轴线与夹具轴线的最大夹角（按给出的安装姿态）
certificate-setting-with = { $name }：{ $value }
certificate-setting-stated = { $half_width }（{ $source }）
certificate-setting-limit = 实验室给出的极限，{ $limit }
certificate-setting-by-example = { $number }（取规范示例值）
certificate-setting-of-unit = { $number }（被校对象的值）
certificate-method =
    .jjf2003 = JJF 2003—2022 各条款
    .joint = 联合最小二乘
    .jjf1536 = JJF 1536—2015 各条款
certificate-basis =
    .jjf2003 = 本次校准依据 { $specification }
    .jjf2003-deviating = 本次校准参照 { $specification }，有偏离，见“说明”
    .joint = 参照 { $specification } 的模型式(1)、式(2)，以联合最小二乘法求得，非该规范条款规定的计算方法
    .joint-deviating = 参照 { $specification } 的模型式(1)、式(2)，以联合最小二乘法求得，非该规范条款规定的计算方法；有偏离，见“说明”
    .jjf1536 = 本次校准依据 { $specification }
    .jjf1536-deviating = 本次校准参照 { $specification }，有偏离，见“说明”
    .clauses = { $basis }；条款 { $clauses }
    .end = { $basis }。
certificate-taken-off = 事先从读数中扣除：{ $title }。
    .sizes = 事先从读数中扣除：{ $title }，{ $sizes }（k = 2）；各项目的 U 已包含其 U。
certificate-absent =
    .jjf-2003-2022 = 表 2 中未得出结果的项目：{ $items }。
    .jjf-1536-2015 = 第 7 章中未得出结果的项目：{ $items }。
certificate-adjusted =
    .no = 无调整记录，结果即调整前及调整后的结果
    .yes = 校准中经过调整，调整前后的结果见下文
certificate-sampling = 无抽样，所校即首页所列对象
certificate-traceability = 校准结果通过上列测量标准及其证书溯源至国际单位制（SI）。
    .in-part = 校准结果通过上列具有可溯源证书的测量标准溯源至国际单位制（SI）；{ $names } 未给出可溯源证书。
    .none = 未给出任何测量标准的可溯源证书，对校准结果不作计量溯源性声明。
    .invalid-run = 本次测量无效，对所列数值不作计量溯源性声明。
certificate-as-found = 被校对象经过调整。本证书的结果与结论为调整后的结果与结论；调整前曾按同一方法校准，并按同一允许限判定，结果如下。
certificate-other-results = 其他结果
certificate-column = 测得值
    .gyro-g-sensitivity = (a) 式(7)
    .gyro-g-sensitivity-second = (b) 扣除地球自转
    .accel-rate-sensitivity = (a) 式(12)、式(13)
    .accel-rate-sensitivity-joint = (a) 式(12)符号
    .accel-rate-sensitivity-second = (b) 模型式(2)符号
certificate-not-decided =
    .gyro-fit-offset = 式(4)的 b 仅供参考，不作判定；陀螺零偏见第 2 项。
certificate-about =
    .gyro-fit-offset = b 由速率点求得，与零偏 B 不同：转轴竖直时，b 还含 g_ii × 1 g 和所敏感的地球自转竖直分量。
    .gyro-g-sensitivity = g 为当地重力加速度。首下标为敏感轴，次下标为输入轴。
    .accel-rate-sensitivity = 单位 m 即 (m/s²)/(rad/s)²。(a) 为静止减转动，与模型式(2)中 p 的符号相反；补偿时应使用 (b)。p 的值仅对本次安装位置有效。
    .accel-rate-sensitivity-joint = 单位 m 即 (m/s²)/(rad/s)²。联合拟合直接得到模型式(2)的 p，即 (b)，补偿时应使用 (b)；(a) 为其相反数，与式(12)、式(13)的符号一致。p 的值仅对本次安装位置有效。
certificate-applied = 允许限适用于：{ $quantities }。
certificate-relative = 相对允许限：{ $limits }。
certificate-missing = 未得：{ $cause }。
    .item = 本次校准未包含此项
    .second = (b) 未能计算

## What the clause's value contains

certificate-contained = { $value }含{ $part }：{ $element } 处最显著，为 { $size }，即 U 的 { $times } 倍；分离后的值见附录。
    .gyro-g-sensitivity-without-earth-rotation = 地球自转
    .accel-rate-sensitivity-without-lever-arm = 杆臂
certificate-value-of =
    .gyro-g-sensitivity-without-earth-rotation = 式(7)的值
    .accel-rate-sensitivity-without-lever-arm = 式(12)、式(13)的值
    .joint = 上述值

## Conditions of the measurement

certificate-turns =
    .known-angle = 已知转角 { $count } 段
    .counts = { $counts } 周
    .at-rates = { $counts } 周，{ $rates } °/s
certificate-dwell =
    .static = 静止 { $seconds } s
    .rate = 恒速转动 { $seconds } s
certificate-positions =
    .rests = 静止 { $count } 段
    .up = 朝天轴 { $count } 种：{ $ups }
    .headings = 方位 { $headings }
    .some-headings = 方位 { $headings }（并非每个朝向都有）
    .not-given = 方位未提供
    .zero = { $count } 个，各 { $seconds } s
certificate-of-axis = { $axis } 轴 { $text }

## Uncertainty

certificate-kind =
    .type-a = A 类评定
    .gum = GUM 法，A 类与 B 类合成
    .as-the-specifications-example = 按规范附录 A 示例
    .monte-carlo = 蒙特卡洛法，A 类与 B 类合成
certificate-rounding = U 为扩展不确定度，U = k·u，包含因子 k 列于各项标题。u 先修约至三位有效数字，U 按 JJF 1059.1 取两位有效数字，只进不舍；测得值修约至与 U 相同的末位。
certificate-u-contains =
    .type-a = 本证书的不确定度仅为 A 类评定，由本次测量数据的分散性得到。转台、参考标准和数据采集系统引入的分量未包含在内；在加入这些分量之前，U 不是完整的测量不确定度。
    .gum = 不确定度按 JJF 1059.1（GUM）的不确定度传播律评定：A 类由本次测量数据得到（计及自相关），B 类由校准装置的极限得到。
    .as-the-specifications-example = 不确定度按本规范附录 A 的示例评定：u1（转台）、u2（数据采集）与 u3（重复性，线性相加）按方和根合成。
    .monte-carlo = 不确定度按 JJF 1059.2（蒙特卡洛法）评定：各输入量的分布经各项的计算式传播；A 类由本次测量数据得到（计及自相关），B 类取自校准装置的技术指标；U 不小于包含区间的半宽。
certificate-u-in-short = { $parts }。
    .type-a = U 仅含 A 类评定的分量
    .gum = U 含 A 类与 B 类分量（GUM）
    .as-the-specifications-example = U 按规范附录 A 示例评定
    .monte-carlo = U 含 A 类与 B 类分量（蒙特卡洛法），包含概率不低于 95 %
certificate-coverage = k = { $k }，正态分布时包含概率约 { $percent } %
    .by-t = k = 2 … { $k }，见各项，包含概率约 95 %
    .up-to = k ≤ { $k }
certificate-coverage-by-t = k 大于 2 者，该项有元素的有效自由度小于 50，按 t 分布取包含概率 95 % 的 k。
certificate-limits = B 类分量的极限：{ $parts }。
    .own = 实验室给出的极限：{ $limits }
    .recommended = 转台和夹具取 { $sources } 推荐的技术指标（视为本装置满足）：{ $limits }
    .assumed = { $limit }假定已知至 { $known }
certificate-limit-of-standard = { $limit } { $half_width }
    .shaped = { $limit } { $half_width }（{ $shape }分布）
    .uncertainty = { $limit } { $U }（k = 2）
certificate-function-of-standard =
    .corrected = { $limit }{ $range }：示值误差在 { $deviation } 内，已修正；U ≤ { $U }（k = { $k }）
    .budgeted = { $limit }{ $range }：示值误差在 { $deviation } 内，未修正，与 U 一并计入；U ≤ { $U }（k = { $k }）
certificate-by-function =
    .corrected = { $paper }，示值误差已修正
    .budgeted = { $paper }，示值误差未修正，与 U 一并计入
    .drift = { $source }，含 { $years } 年的漂移
certificate-assumed =
    .gravity = 假定：由纬度和高程计算，重力异常不超过 50 mGal
    .latitude = 假定：纬度给出至 0.1°
    .level = 假定：外轴铅垂度与轴线垂直度相当
certificate-axes =
    .fixture = 测得值以夹具的轴线为准：U 不含被校对象基面相对夹具的倾斜。
    .unit = 测得值以被校对象自身的轴线为准，其相对夹具轴线的转动按记录中给出的安装姿态；U 既不含该姿态的误差，也不含基面的倾斜。
    .mounting-plane = 测得值以被校对象安装基面的轴线为准：U 已含基面相对夹具的倾斜。
    .mounting-unknown = 委托要求测得值以被校对象安装基面的轴线为准，但基面相对夹具的倾斜未知，U 中未含：U 仅对夹具的轴线成立。
certificate-axes-setting =
    .fixture = 夹具的轴线
    .unit = 被校对象的轴线（按给出的安装姿态）
    .mounting-plane = 安装基面的轴线
certificate-switch-on = 零位（零偏、拟合截距、零位偏移）为本次通电期间的平均。U 已含噪声及弛豫时间至 5000 s 的慢变化；不含各次通电之间的变化，若取全时平均则须另加。
certificate-flatness =
    .jjf-2003-2022 = 台面和夹具的平面度（表 1、6.2：0.02 mm）未计入：其引起的基面倾角取决于安装基面的长度，规范未给出；按 100 mm 计约 41″，大于夹具垂直度的极限。
    .jjf-1536-2015 = 夹具的平面度（6.2.2 b）：0.01 mm）未计入：其引起的基面倾角取决于安装基面的长度，规范未给出；按 100 mm 计约 21″，大于夹具垂直度的极限。
certificate-capability =
    .stated = 本实验室给出的 U 不小于其校准和测量能力（CMC，k = 2）：{ $items }评定的 U 小于该能力，以该能力给出。
    .outside = 本实验室的校准和测量能力未覆盖{ $items }，这些项目不在认可范围内：本证书不使用认可标识。
certificate-capability-item = { $item }（{ $symbols }）
certificate-validation = { $record }。
certificate-distribution =
    .normal = 正态
    .rectangular = 均匀
    .triangular = 三角
    .arcsine = 反正弦
    .t = t
certificate-budget-of = { $symbol } 的评定（该项中 u 最大者）
certificate-budgets =
    .gum = 各输入量相互独立；灵敏系数的单位为结果单位除以输入量单位。U = k·u；有效自由度均不小于 50 时 k = 2，否则取该项各元素中最大的 k。95 % 区间半宽由各分布的传播（JJF 1059.2）得到。
    .as-the-specifications-example = 按规范附录 A 的示例：u1 和 u2 的灵敏系数取 1；u3 为各位置的标准不确定度之和，均以结果的单位表示；U = 2·u。
    .monte-carlo = 各输入量相互独立，按其分布抽样，经该项计算式传播（JJF 1059.2）；灵敏系数和贡献为线性近似。U 为概率对称包含区间的半宽，取该项各元素中最大的 k = U/u。

## Statement of conformity

certificate-rule =
    .simple-acceptance = 简单接受（JCGM 106，8.2）：测得值在允许限内即为符合，不另留保护带（w = 0）
    .guard-band = 保护带判定（JCGM 106，8.3）：测得值在接受限内方为符合，接受限由允许限内移 w = { $w }
    .guard-band-outwards = 保护带判定（JCGM 106，8.3）：测得值在接受限内方为符合，接受限由允许限外移 w = { $w }
    .shared-risk = 风险共担（JCGM 106，8.2）：按双方约定，测得值在允许限内即为符合（w = 0）
    .capability = { $rule }，要求 C_m = T/(2 U) ≥ { $needed }（T 为允许区间宽度）；否则仅当测得值 ± U 全部在允许限外时判为不合格，其余不作判定
    .unbounded = { $rule }，单侧允许限且未约定 U 的上限：仅当 P_c ≥ 95 % 或 ≤ 5 % 时判定
    .bound = { $item }要求 U ≤ { $U_max }（测得值 ± U 全部在允许限外的除外）
    .coverage-factor = U 的 k = { $k }
certificate-rule-of = { $items }：{ $rule }
certificate-risk = { $parts }（JCGM 106，9.3）
    .acceptance = 合格判定的错误接受概率 1 − P_c，最大者 { $chance } ({ $symbol })
    .rejection = 不合格判定的错误拒绝概率 P_c，最大者 { $chance } ({ $symbol })
certificate-risk-how = 合格概率与误判风险由测得值及其标准不确定度 u（正态分布；自由度有限时为 t 分布）计算，未用先验信息（JCGM 106，9.3）。
certificate-global-risk = { $parts }（JCGM 106，9.5）
    .item = { $item }：用户风险 { $consumer }，生产方风险 { $producer }
certificate-marks =
    .absent = “—”：未规定允许限；“未得”：未能得到该值，原因见表下
    .chance = 判定栏中的百分数为合格概率 P_c
    .conditional = “有条件”：值距允许限小于 U，或超出允许限而按规则接受（ILAC-G8:09/2019）
    .nothing-accepted = “接受限 –”：U 过大，扣除保护带后没有接受区间
certificate-reason-alike = { $reason }；{ $symbols } 情况相同（数值各异）
certificate-see-remarks = “说明”中标有“影响判定”的 { $count } 条。
certificate-accepted = 接受限 { $limits }
certificate-segments =
    .static = 静止 { $count } 段
    .rate = 恒速转动 { $count } 段
    .rotation = 已知转角 { $count } 段
    .settle = 稳定 { $count } 段
    .transition = 过渡 { $count } 段
certificate-remark = { $remark }[{ $segments }]
    .alike = { $remark }另有 { $count } 段情况相同（数值各异）。
    .blocks = { $remark }本条影响判定：不得判为合格。
    .invalid = { $remark }本条使本次测量无效。
certificate-reading-of = { $items }
certificate-unregistered = 此标识未在册

## Labels of the layout

certificate-figure =
    .rate-residuals = 残差与角速率的关系
    .rate-residuals-caption = 点：各轴读数均值减去标度因数与转台角速率之积，再减去这些差值的平均值。灰色区域：该角速率下拟合直线的 ± U，由标度因数和拟合零偏的 U 得出。
    .tumble = 多位置试验的残差
    .tumble-caption = 各加速度计读数均值减去由标度因数、交叉耦合系数和零偏在该位置（以朝上的轴命名）给出的值。误差棒：该模型的 ± U。
    .allan = Allan 标准差
    .allan-caption = 本次测量中最长静止段的重叠 Allan 标准差。误差棒：按白噪声自由度得出的 ± U。
    .history = 被校对象的历史
    .history-caption = 以往证书的值减去本证书的值，及各自的 ± U。证书：{ $certificates }。
certificate-label-certificate-number = 证书编号
certificate-label-report-number = 报告编号
certificate-label-page = 第 { $here } 页 共 { $last } 页
certificate-label-basis = 校准依据
certificate-label-object = 被校对象的状态与配置
certificate-label-traceability = 计量溯源性
certificate-label-standards = 所用测量标准
certificate-label-name = 名称
certificate-label-serial = 出厂编号
certificate-label-accuracy = 准确度/等级
certificate-label-standard-certificate = 证书编号
certificate-label-valid-until = 有效期至
certificate-label-environment = 环境条件
certificate-label-condition = 条件
certificate-label-during = 校准期间
certificate-label-required = 规范要求（第 6 章）
certificate-label-conditions = 校准条件
certificate-label-axis = 轴
certificate-label-rate-points = 角速率点（°/s）
certificate-label-points = 点数
certificate-label-rate-for-p = p 所用角速率（°/s）
certificate-label-as-found = 调整前与调整后
certificate-label-found = 调整前
certificate-label-left = 调整后
certificate-label-found-verdict = 调整前判定
certificate-label-results = 校准结果
certificate-label-figures = 图示
certificate-label-uncertainty = 测量不确定度说明
certificate-label-annex = 附录
certificate-label-annex-introduction = 供实验室及需了解结果由来者使用：对规范条文的理解、测量不确定度的评定、图示、附加信息、数据来源。本附录不改变校准结果和结论。
certificate-label-annex-follows = 后附附录：对规范条文的理解、测量不确定度的评定、图示、附加信息、数据来源。
certificate-label-segments = “说明”所涉各段
certificate-label-conformity = 符合性判定
certificate-label-reasons = 判定理由
certificate-label-remarks = 说明
certificate-label-readings = 对规范条文的理解
certificate-label-trace = 数据来源与处理信息
certificate-label-information = 附加信息（不作判定）
certificate-label-information-introduction = 由本次测量数据得出，非规范条款的结果，不参与符合性判定。记为“测得值 ± U”，自由度少时按 t 分布取 k。没有数值或没有 U 的原因见各项说明。
certificate-label-not-determined = 未得
certificate-label-clause = 条款
certificate-label-element = 项目
certificate-label-expanded-uncertainty = 不确定度
certificate-label-of-a = (a)
certificate-label-of-b = (b)
certificate-label-unit = 单位
certificate-label-limits = 允许限
certificate-label-verdict = 判定
certificate-label-conclusion = 结论
certificate-label-job-title = 职务
certificate-label-issue-date = 签发日期
certificate-label-stamp = 校准专用章
certificate-label-end = 以下空白
certificate-label-only-this = 本证书结果仅对所校对象有效；未经实验室书面同意，不得部分复制。
certificate-label-budgets = 不确定度评定
certificate-label-equipment-limits = 校准装置的极限
certificate-label-input = 输入量
certificate-label-type = 类别
certificate-label-distribution = 分布
certificate-label-standard-uncertainty = 标准不确定度
certificate-label-sensitivity = 灵敏系数
certificate-label-contribution = 分量
certificate-label-share = 占比 %
certificate-label-dof = 自由度
certificate-label-half-width = 半宽，或 U（k = 2）
certificate-label-source = 来源
certificate-label-budget-element = 元素
certificate-label-type-a = A 类
certificate-label-type-b = B 类
certificate-label-combined = 合成
certificate-label-effective-dof = 有效自由度
certificate-label-expanded = 扩展
certificate-label-half-width-95 = 95 % 区间半宽
certificate-label-every-element = 各元素
certificate-label-in = 的单位：
certificate-label-no-symbol = 附录 B|B 类|X 轴
certificate-seal = 证书编号及所依据记录的 SHA-256 值（同首页二维码）；含该记录的数字校准证书（DCC）附于本文件。
    .signed = 本文件及 DCC 由实验室电子签名。
    .by-hand = 须手工签名：本文件无电子签名。
