## The Digital Calibration Certificate: what only a machine-readable certificate says.

dcc-record = Record from which this certificate was made
dcc-results = Results of the calibration
dcc-as-found = Results as found, before the adjustment
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
