## The verdict on a unit: its words and its reasons.

conformity-verdict =
    .pass = pass
    .fail = fail
    .inconclusive = inconclusive
conformity-conditional =
    .pass = conditional pass
    .fail = conditional fail
conformity-quantity =
    .value = the value by the clause
    .value-without-earth-rotation = the value with Earth's rotation removed
    .value-model = the value with the sign of model (2)
conformity-no-tolerance = no limits were given for this product model
conformity-invalid-run = the run is invalid: nothing is decided on the unit
conformity-expired = { $name } ({ $serial }): its certificate was valid until { $valid_until }, before { $day }
conformity-taken-to-be-met = U rests on limits that { $sources } recommends and this equipment is only taken to meet ({ $limits }); a pass needs those of the laboratory's own equipment
conformity-smaller-than-stated = { $limit }: the budget takes { $used } ({ $shape }; { $source }), less than the { $stated } ({ $stated_shape }) that { $paper } states of the equipment: correct one of them, and certify again
conformity-subject = { $item } { $symbol }
    .of-two = { $item } { $symbol }, { $quantity }
conformity-measured = { $subject }: { $value }, U = { $U } (k = { $k })
conformity-where =
    .outside = is outside { $limits }
    .guard-band = is inside { $limits } but outside the acceptance limits { $accepted }
conformity-outside = { $measured }, { $where }{ $risk }
conformity-condition = { $verdict }{", "}
conformity-risk =
    .acceptance = {" "}({ $condition }false acceptance { $chance })
    .rejection = {" "}({ $condition }false rejection { $chance })
conformity-conditional-pass =
    .near = { $measured }, is accepted but lies within U of its limit, { $limits }{ $risk }
    .outside = { $measured }, is accepted but lies outside its limit, { $limits }{ $risk }
conformity-too-uncertain = { $subject }: { $value }, U = { $U }, { $why }: nothing can be decided
conformity-uncertain =
    .agreed = larger than the agreed { $agreed }
    .unbounded = the probability of conformity with { $limits } is { $chance }, and nothing bounds U: state U_max, the largest U at which this limit is decided on
    .capability = C_m = T/(2 U) = { $capability } for { $limits }, below { $needed }
    .interval = larger than half the interval { $limits }
conformity-without-uncertainty = { $item } ({ $elements }): no uncertainty above zero was found, so nothing can be decided
conformity-missing = { $item } ({ $elements }) not determined: { $why }
conformity-no-cause = no cause was given
conformity-largest-rate =
    .not-given = The unit's largest input rate, which { $clause } asks for, is not stated, so whether it was included was not checked.
    .missed = The unit's largest input rate, which { $clause } asks for, is { $largest } °/s; about { $axes } it was not included (up to { $reached } °/s).
    .included = The unit's largest input rate is { $largest } °/s; it was included about every axis.
conformity-deviation =
    .open = Deviation: { $sentence } This prevents a pass, unless the client's order waives the condition ({ $name }).
    .waived = Deviation: { $sentence } The client's order waives this condition ({ $name }).
conformity-waivable =
    .largest-rate = largest rate
    .environment = environment
