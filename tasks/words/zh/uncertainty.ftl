## Input quantities of the uncertainty budgets.

uncertainty-repeatability = 测量重复性
uncertainty-drift-in-run = 测量期间零位和增益的漂移
uncertainty-resolution = 分辨力
uncertainty-turned-angle = { $limit }（整周转角）
uncertainty-creep = { $limit }（保持期间）
uncertainty-zero-offset = 零偏
uncertainty-example-table = 位置速率转台
uncertainty-example-acquisition = 数据采集系统
uncertainty-example-repeatability = 测量重复性（线性相加）
uncertainty-gravity = 当地重力加速度
uncertainty-latitude = 纬度
uncertainty-rate = 转台角速率（360°平均）
uncertainty-encoder-time = 编码器查询时刻
uncertainty-commanded-rate = 转台实际角速率与指令角速率之差
uncertainty-ripple = 转台角速率平稳性
uncertainty-position = 角位置定位精度
uncertainty-angle-repeatability = 角位置测量重复性
uncertainty-axes = 轴线垂直度
uncertainty-mounting = 被校对象基面在夹具中的安装
uncertainty-time-base = 记录的时基
uncertainty-heading = 方位
uncertainty-level = 外轴铅垂度
uncertainty-fixture = 夹具垂直度
uncertainty-rate-fast = 转台角速率（≥ 10 °/s）
uncertainty-rate-medium = 转台角速率（1~10 °/s）
uncertainty-rate-slow = 转台角速率（< 1 °/s）
uncertainty-table-angle = 转台角位移
uncertainty-horizontal-earth = 地球自转水平分量（非整圈部分）

## 校准结果的证据文件。

evidence-coverage = U = k·u；k = { $k }（包含概率 { $probability } %）；项目中某一值的有效自由度小于 { $dof } 时，取该项目各值按 t 分布（包含概率 { $probability } %）所得包含因子的最大值，并向上修约至两位小数
