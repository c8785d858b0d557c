## 验证记录页面。

validation-page-title = 估计方法的验证
validation-page-made = { $items } 项中有 { $valid } 项通过验证。{ $date } 由 { $code } 生成，种子 { $seed }，用时 { $seconds } s。
validation-page-fingerprints = 源代码指纹：
validation-page-method = 每台单元均由虚拟台位按物理规律仿真：噪声为白噪声，或白噪声与各自强度的闪烁噪声之和；转台、夹具、重力与纬度的误差在不确定度评定所给的限内逐次抽取。某一项通过验证须：算例得到复现，理想测量还原真值，其他程序结果一致，且所给 95 % 区间在至少 { $least } % 的情形中包含真值；其中某一元素通过验证，须其自身的比例在 { $least } %～{ $most } % 内。
validation-page-picture = 95 % 区间包含真值的比例及其自身的 95 % 区间；绿色为要求范围。
validation-page-column-method = 方法
validation-page-column-item = 项目
validation-page-column-units = 单元数
validation-page-column-inside = 95 % 区间内
validation-page-column-interval = （其 95 % 区间）
validation-page-column-expanded = U 内
validation-page-column-rms = z 均方根
validation-page-column-valid = 通过
validation-page-worked-example = 算例
validation-page-truth-recovery = 真值还原
validation-page-coverage = 覆盖率
validation-page-independent-program = 独立程序
validation-page-yes = 是
validation-page-no = 否
validation-page-in-words = 文字说明
validation-page-by-element = 各元素
validation-page-outside = { $short } 个元素未经验证：其区间包含真值的比例低于 { $least } %，不得据以判为合格。{ $long } 个元素的区间包含真值的比例高于 { $most } %：区间偏宽，但有效。
validation-page-column-element = 元素
