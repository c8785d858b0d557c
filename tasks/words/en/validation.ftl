## The validation record, and what the gate makes of it.

validation-stale = The estimation by the method { $method } is not validated for this version of the program
validation-failed = The estimation of { $item } is not validated for this version of the program ({ $evidence } not shown)
    .element = The estimation of { $item } is not validated for { $elements }: of simulated units its 95 % interval holds the truth outside { $low } % to { $high } %
validation-none = No validation record of this version covers the estimation
validation-record = Estimation validated by the record of { $record }: { $valid } of { $items } items
    .in-part = Estimation validated by the record of { $record }: { $valid } of { $items } items in full; not validated are { $elements }
validation-elements = { $item } { $elements }
validation-coverage = { $share } of { $values } values of { $units } simulated units lie within the stated 95 % interval; { $low } % to { $high } % over at least { $fewest } units are aimed at
    .too-long = { $share } of { $values } values of { $units } simulated units lie within the stated 95 % interval; { $low } % to { $high } % over at least { $fewest } units are aimed at; the uncertainty is larger than it need be
validation-example = { $specification }, Appendix A ({ $clause }) prints u_c = { $u_c }, U = { $U }; found { $result }
validation-independent = plain least squares is { $values } u away ({ $limit } u allowed); GTC agrees with the budgets within { $budgets } ({ $close } allowed)
validation-recovery = an ideal run gives the truth back within { $error } { $unit }; { $close } is asked
