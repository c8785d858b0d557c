## 运行页面。

pages-light = 浅色
pages-dark = 深色
pages-no-such-page = 没有这个页面
pages-not-answered = 无法显示
pages-no-database = 无法访问目录数据库；本页会自动重试

pages-line = 产线
    .about = 各工位当前的工作，以及产线今日的产出
pages-line-no-station = 此数据目录中尚未从任何工位采集过数据。

pages-runs = 测量记录
    .about = 所有测量记录及其每一步骤的状态
pages-runs-count = { $count ->
   *[other] 共 { $count } 条测量记录
}

pages-validity =
    .valid = 有效
    .remarks = 有效但有说明
    .invalid = 无效
    .missing = 未评定
pages-result =
    .whole = 完整
    .partial = 缺 { $count } 项
    .missing = 无结果
    .failed = 重新处理失败
pages-certificate =
    .draft = 草稿
    .checked = 已核验
    .issued = 已签发
    .amended = 已被修订
    .withdrawn = 已撤销
    .missing = 无
pages-verdict-missing = 无

pages-column-id = 记录
pages-column-recorded-on = 测量日期
pages-column-station = 工位
pages-column-model = 型号
pages-column-serial = 编号
pages-column-manufacturer = 制造商
pages-column-validity = 测量有效性
pages-column-result = 结果
pages-column-verdict = 判定
pages-column-state = 证书状态
pages-column-certificate = 证书
pages-column-due = 到期
pages-column-procedure = 程序
pages-column-method = 方法
pages-column-seconds = 时长 (s)
pages-column-recording-id = 原始记录

## 表格自身的用语；标识符的末尾是表格自己的键。

pages-grid-contains = 包含
pages-grid-notContains = 不包含
pages-grid-startsWith = 开头是
pages-grid-endsWith = 结尾是
pages-grid-equals = 等于
pages-grid-notEqual = 不等于
pages-grid-blank = 为空
pages-grid-notBlank = 不为空
pages-grid-lessThan = 小于
pages-grid-lessThanOrEqual = 小于或等于
pages-grid-greaterThan = 大于
pages-grid-greaterThanOrEqual = 大于或等于
pages-grid-inRange = 介于
pages-grid-before = 早于
pages-grid-after = 晚于
pages-grid-andCondition = 且
pages-grid-orCondition = 或
pages-grid-filterOoo = 筛选…
pages-grid-noRowsToShow = 没有记录
pages-grid-loadingOoo = 加载中…
