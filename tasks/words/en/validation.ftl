## The validation record, and what the gate makes of it.

validation-stale = Estimation by the method { $method } is not validated for this version of the program
validation-failed = The estimation of { $item } is not validated for this version of the program ({ $evidence } not shown)
    .element = The estimation of { $item } is not validated for { $elements }: over simulated units the coverage of its 95 % interval is below { $low } %
validation-none = No validation record of this version covers the estimation
validation-record = Estimation validated by the record of { $record }: { $valid } of { $items } items
    .in-part = Estimation validated by the record of { $record }: { $valid } of { $items } items in full; not validated: { $elements }
validation-within = the conditions of this run lie in the validated scenarios: { $scenarios }
    .none = the conditions of this run ({ $conditions }) lie in none of the validated scenarios
validation-elements = { $item } { $elements }
validation-coverage = { $share } of { $values } values of { $units } simulated units lie within the stated 95 % interval; the target is { $low } % to { $high } % over at least { $fewest } units
    .too-long = { $share } of { $values } values of { $units } simulated units lie within the stated 95 % interval; the target is { $low } % to { $high } % over at least { $fewest } units; the uncertainty is larger than necessary
validation-example = { $specification }, Appendix A ({ $clause }) gives u_c = { $u_c }, U = { $U }; obtained: { $result }
validation-independent = ordinary least squares differs by { $values } u ({ $limit } u allowed); GTC agrees with the budgets within { $budgets } ({ $close } allowed)
validation-recovery = an ideal run recovers the truth within { $error } { $unit }; { $close } is required
