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
conformity-no-tolerance = no limits are defined for this product model
conformity-invalid-run = the run is invalid: no decision is made on the unit
conformity-expired = { $name } ({ $serial }): its certificate was valid until { $valid_until }, before { $day }
conformity-check-failed = { $name } ({ $serial }): its intermediate check of { $day } ({ $what }) found { $result }, beyond the limit of ±{ $limit }
conformity-taken-to-be-met = U is based on limits recommended by { $sources } that this equipment is merely assumed to meet ({ $limits }); a pass requires those of the laboratory's own equipment
conformity-smaller-than-stated = { $limit }: the budget uses { $used } ({ $shape }; { $source }), less than the { $stated } ({ $stated_shape }) stated for the equipment by { $paper }: correct one of them and certify again
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
conformity-too-uncertain = { $subject }: { $value }, U = { $U }, { $why }: no decision is possible
conformity-uncertain =
    .agreed = larger than the agreed { $agreed }
    .unbounded = the probability of conformity with { $limits } is { $chance }, and U is not limited: specify U_max, the largest U at which this limit may be decided
    .capability = C_m = T/(2 U) = { $capability } for { $limits }, below { $needed }
    .interval = larger than half the interval { $limits }
conformity-without-uncertainty = { $item } ({ $elements }): no uncertainty above zero was obtained, so no decision is possible
conformity-missing = { $item } ({ $elements }) not determined: { $why }
conformity-no-cause = no cause stated
conformity-largest-rate =
    .not-given = The unit's largest input rate, required by { $clause }, is not stated, so its inclusion could not be checked.
    .missed = The unit's largest input rate, required by { $clause }, is { $largest } °/s; it was not included about { $axes } (up to { $reached } °/s).
    .included = The unit's largest input rate is { $largest } °/s; it was included about every axis.
conformity-deviation =
    .open = Deviation: { $sentence } It prevents a pass unless the client's order waives the condition ({ $name }).
    .waived = Deviation: { $sentence } The client's order waives this condition ({ $name }).
conformity-waivable =
    .largest-rate = largest rate
    .environment = environment
