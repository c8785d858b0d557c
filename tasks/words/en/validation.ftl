## The validation record, and what the gate makes of it.

validation-stale = Estimation by the method { $method } is not validated for this version of the program
validation-failed = The estimation of { $item } is not validated for this version of the program ({ $evidence } not shown)
    .element = The estimation of { $item } is not validated for { $elements }: over simulated units the coverage of its 95 % interval is below { $low } %
validation-none = No validation record of this version covers the estimation
validation-record = Estimation validated by the record of { $record }: { $valid } of { $items } items
    .in-part = Estimation validated by the record of { $record }: { $valid } of { $items } items in full; not validated: { $elements }
validation-within = the conditions of this run lie in the validated scenarios: { $scenarios }
    .none = the conditions of this run ({ $conditions }) lie in none of the validated scenarios
    .list = { $first }, { $rest }
validation-scenario = { $name ->
    [mount] a stated mount off square
    [labels] labels alone with the limit of their rates stated
    [labels-mount] labels alone and a stated mount off square
    [polled] polled encoders whose times are stated
    [one-heading] positions at one heading
    [few-rates] few rates
    [flicker] noise that is still 1/f over hours
    [warming] a unit that warms
    [drift] zeros that drift
    [coarse-steps] steps that hide the noise
    [base] tilt of the unit's base
   *[in-order] everything in order
}
validation-elements = { $item } { $elements }
validation-coverage = { $share } of { $values } values of { $units } simulated units lie within the stated 95 % interval; the target is { $low } % to { $high } % over at least { $fewest } units
    .too-long = { $share } of { $values } values of { $units } simulated units lie within the stated 95 % interval; the target is { $low } % to { $high } % over at least { $fewest } units; the uncertainty is larger than necessary
validation-example = { $specification }, Appendix A ({ $clause }) gives u_c = { $u_c }, U = { $U }; obtained: { $result }
validation-independent = ordinary least squares differs by { $values } u ({ $limit } u allowed); GTC agrees with the budgets within { $budgets } ({ $close } allowed)
validation-recovery = an ideal run recovers the truth within { $error } { $unit }; { $close } is required
