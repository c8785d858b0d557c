## 命令行向终端前的人员提出的请求。

flows-press-enter = 完成后按回车键。

# 重新处理的插图。
changed-title = { $done } 个结果中的变化，其中 { $unchanged } 个不变
changed-in-U = 值的变化 / U（自 { $least } 起计）
changed-in-part = 值的变化 / U（自 { $least } 起计）；×：仅此前或仅现在可确定
changed-nothing = 没有变化
flows-who-operates = 校准员（与证书上的姓名一致）：

# 终端对结果的说明。
flows-run =
    .valid = 测量有效
    .remarks = 测量有效但有备注，不得判为合格
    .invalid = 测量无效，对被校对象不作判定
flows-not-determined = 未确定
flows-for-information = 附加信息，不作判定
flows-column =
    .item = 项目
    .quantity = 量
    .value = 测得值
    .unit = 单位
    .missing = 缺失的物理效应
    .share = 占比
    .channels = 通道
    .parameter = 参数
    .effect = 效应
    .carrier = 承载者
    .since = 起始
    .runs = 测量次数
flows-due = 复校日期 { $day }
flows-next =
    .draft = 下一步：mimucal check { $number } --by NAME，然后 mimucal issue { $number } --by NAME
    .checked = 下一步：mimucal issue { $number } --by NAME
flows-left-over = 剩余，每自由度 χ²：{ $channels }
flows-more-elements = 另有 { $count } 个要素，见报告
flows-verdict-of = { $item } 的判定：{ $change }
flows-left-out = 未计入：{ $run }：{ $why }
flows-of-runs = { $verdict }（{ $runs } 次测量）
