## 复校提醒，以及复校间隔的建议。

reminder-title =
    .before = { $unit } 应于 { $due } 复校
    .after = { $unit } 已过复校日期 { $due }
reminder-body =
    .before = { $unit } 按证书 { $certificate }（{ $issued } 签发）的约定，应于 { $due } 复校。本提醒为到期前 { $days } 天。{ $laboratory }
    .after = { $unit } 按证书 { $certificate }（{ $issued } 签发）的约定，应于 { $due } 复校，此后未再签发证书。本提醒为到期后 { $days } 天。{ $laboratory }
reminder-entry = { $unit } 复校到期
reminder-entry-of = 按证书 { $certificate } 的约定。
reminder-advice =
    .too-few-unknown = { $unit }：有判定的间隔仅 { $intervals } 个，不足以采用可靠性法（至少 3 个）；维持约定的 { $agreed } 天。
    .shorten-unknown = { $unit }：{ $intervals } 个间隔结束时均不合格；应缩短约定的 { $agreed } 天。
    .keep = { $unit }：{ $intervals } 个间隔中 { $conforming } 个结束时合格。95 % 可靠度对应 { $days } 天（90 % 概率介于 { $shortest } 与 { $longest } 天之间），与约定的 { $agreed } 天不矛盾：维持不变。
    .shorten = { $unit }：{ $intervals } 个间隔中 { $conforming } 个结束时合格。95 % 可靠度对应 { $days } 天（90 % 概率介于 { $shortest } 与 { $longest } 天之间），短于约定的 { $agreed } 天：应予缩短。
    .may-be-longer = { $unit }：{ $intervals } 个间隔中 { $conforming } 个结束时合格。95 % 可靠度对应 { $days } 天（90 % 概率介于 { $shortest } 与 { $longest } 天之间），长于约定的 { $agreed } 天：可延长至 { $shortest } 天。
reminder-no-advice =
    .none = 计算“{ $serial }”的复校间隔，需要同一单元已签发且载明校准日期的证书；现无此类证书。
    .several = 计算“{ $serial }”的复校间隔，需要同一单元已签发且载明校准日期的证书；现有证书属于 { $units }。
    .not-agreed = 证书 { $certificate } 未载明复校日期，无从起算：请在委托单中约定（recalibration_agreed = true）。
alert-title = mimucal：需要处理
