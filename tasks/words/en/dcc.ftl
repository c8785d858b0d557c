## The Digital Calibration Certificate: what only a machine-readable certificate says.

dcc-remark = { $remark } [{ $segments }]
dcc-record = Record from which this certificate was made
dcc-results = Results of the calibration
dcc-as-found = Results as found, before the adjustment
dcc-covariance = All elements together, with their covariance
    .how = { $count } elements by item and element in SI units, with the covariance of type A and type B together. The coverage region is an ellipsoid; its factor is that of a vector of { $count } elements, not of one.
dcc-information = For information, not decided on
dcc-element = { $element }: { $column }
dcc-field = { $label }: { $value }
dcc-rates = Axis { $axis }, rate points (°/s): { $points }; { $count } points
dcc-no-number = not determined
dcc-chance = Probability of conformity { $chance }
dcc-replaces = Replaces certificate { $number } of { $day }
dcc-limit =
    .lower = Lower limit
    .upper = Upper limit
    .accept-lower = Lower acceptance limit
    .accept-upper = Upper acceptance limit
dcc-required = { $name }: { $measured }; { $by }: { $required }
dcc-curves = Curves
dcc-curve =
    .x = Abscissa
    .y = Ordinate
