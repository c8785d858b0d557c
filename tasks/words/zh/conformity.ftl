## The verdict on a unit: its words and its reasons.

conformity-verdict =
    .pass = 合格
    .fail = 不合格
    .inconclusive = 无法判定
conformity-conditional =
    .pass = 有条件合格
    .fail = 有条件不合格
conformity-quantity =
    .value = 条款给出的值
    .value-without-earth-rotation = 扣除地球自转后的值
    .value-model = 符号按模型式(2)的值
conformity-no-tolerance = 未提供该型号的允许限
conformity-invalid-run = 本次测量无效：不对被校对象作任何判定
conformity-expired = { $name }（{ $serial }）：其证书有效期至 { $valid_until }，早于 { $day }
conformity-check-failed = { $name }（{ $serial }）：{ $day } 的期间核查（{ $what }）结果为 { $result }，超出限值 ±{ $limit }
conformity-taken-to-be-met = U 所依据的技术指标仅为 { $sources } 的推荐值，并非本实验室装置的实际指标（{ $limits }）；判定合格须采用本实验室装置的技术指标
conformity-smaller-than-stated = { $limit }：不确定度评定所取为 { $used }（{ $shape }；{ $source }），小于 { $paper } 给出的 { $stated }（{ $stated_shape }）：请更正其一，再重新出具证书
conformity-subject = { $item } { $symbol }
    .of-two = { $item } { $symbol }，{ $quantity }
conformity-measured = { $subject }：{ $value }，U = { $U }（k = { $k }）
conformity-where =
    .outside = 超出 { $limits }
    .guard-band = 在允许限 { $limits } 内，但超出接受限 { $accepted }
conformity-outside = { $measured }，{ $where }{ $risk }
conformity-condition = { $verdict }，
conformity-risk =
    .acceptance = （{ $condition }错误接受概率 { $chance }）
    .rejection = （{ $condition }错误拒绝概率 { $chance }）
conformity-conditional-pass =
    .near = { $measured }，判为符合，但距允许限 { $limits } 小于 U{ $risk }
    .outside = { $measured }，判为符合，但超出允许限 { $limits }{ $risk }
conformity-too-uncertain = { $subject }：{ $value }，U = { $U }，{ $why }，无法判定
conformity-uncertain =
    .agreed = 大于约定的 { $agreed }
    .unbounded = 相对允许限 { $limits } 的合格概率为 { $chance }，且 U 无上限约定：请给出 U_max
    .capability = 允许区间 { $limits } 的 C_m = T/(2 U) = { $capability }，小于 { $needed }
    .interval = 大于允许区间 { $limits } 的一半
conformity-without-uncertainty = { $item }（{ $elements }）：未得到大于零的不确定度，无法判定
conformity-missing = { $item }（{ $elements }）未得：{ $why }
conformity-no-cause = 未说明原因
conformity-largest-rate =
    .not-given = { $clause } 要求包括被校对象的最大输入角速率；未提供该值，故未核查速率点是否包括该值。
    .missed = { $clause } 要求包括被校对象的最大输入角速率 { $largest } °/s；{ $axes } 轴的速率点未包括该值（最大 { $reached } °/s）。
    .included = 被校对象的最大输入角速率为 { $largest } °/s；各轴速率点均包括该值。
conformity-deviation =
    .open = 偏离：{ $sentence }除非送校单位在委托单中免除该条件（{ $name }），否则不得判为合格。
    .waived = 偏离：{ $sentence }送校单位在委托单中免除该条件（{ $name }）。
conformity-waivable =
    .largest-rate = 最大角速率
    .environment = 环境条件
