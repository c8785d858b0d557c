## 命令行向终端前的人员提出的请求。

flows-press-enter = 完成后按回车键。

# 重新处理的插图。
changed-title = { $done } 个结果中的变化，其中 { $unchanged } 个不变
changed-in-U = 值的变化 / U（自 { $least } 起计）
changed-in-part = 值的变化 / U（自 { $least } 起计）；×：仅此前或仅现在可确定
changed-nothing = 没有变化
flows-who-operates = 校准员（与证书上的姓名一致）：
