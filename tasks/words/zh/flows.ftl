## 命令行向终端前的人员提出的请求。

flows-press-enter = 完成后按回车键。
