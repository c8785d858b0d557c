## 复校提醒，以及复校间隔的建议。

recall-title =
    .before = { $unit } 应于 { $due } 复校
    .after = { $unit } 已过复校日期 { $due }
recall-body =
    .before = { $unit } 按证书 { $certificate }（{ $issued } 签发）的约定，应于 { $due } 复校。本提醒为到期前 { $days } 天。{ $laboratory }
    .after = { $unit } 按证书 { $certificate }（{ $issued } 签发）的约定，应于 { $due } 复校，此后未再签发证书。本提醒为到期后 { $days } 天。{ $laboratory }
recall-entry = { $unit } 复校到期
recall-entry-of = 按证书 { $certificate } 的约定。
