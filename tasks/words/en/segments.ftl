## Checks of a recording's segments. $segment: its name; $channel: a column of the unit's stream.

segments-position-contradicted = { $segment }: labelled { $label } up, but accel_{ $axis } reads { $reading } m/s²: { $shown ->
        [none] no axis lies within 10° of what is read; it was left out
       *[other] gravity shows { $shown } up, and that was used
    }.
segments-rate-contradicted = { $segment }: labelled { $label } deg/s about { $axis }, but { $witness ->
        [table] the table
       *[other] { $witness }
    } shows { $shown } deg/s: { $witness ->
        [table] the table's rate was used
       *[other] it was left out
    }.
segments-unsteady-rate = { $segment }: by { $witness ->
        [table] the table
       *[other] { $witness }
    } the rate changed by { $wander } deg/s during the segment; { $clause } asks for a steady rate ({ $percent } %).
segments-corrupted-rows = { $segment }: { $out } of { $rows } rows far from the rest ({ $channels }) were left out of the mean.
segments-disturbed = { $segment }: { $out } of { $rows } rows far from the rest ({ $channels }) were left out of the mean; { $burst } of them in a row: it was disturbed.
segments-stuck = { $segment }: { $channel } stood still at { $value } for { $rows } rows from t = { $time } s.
segments-lost-samples = { $segment }: { $lost } samples lost in { $gaps } gaps, the longest { $longest } s at t = { $time } s.
segments-short-dwell = { $short } of { $held } segments last less than the { $asked } s that { $clause } asks for at each point: { $listed }.
segments-coarse-step = The output's step is larger than its noise ({ $steps }, SI units): no averaging removes it, a mean may be off by half a step.
segments-overlapping-segments = Segments overlap, so the same samples are counted twice: { $more ->
        [0] { $pairs }
       *[other] { $pairs } and { $more } more pairs
    }.
segments-pair = { $first } and { $second }
segments-environment = { $segment }: { $quantity ->
        [temperature] air temperature
       *[humidity] relative humidity
    } { $worst } { $unit } is outside { $low } to { $high } { $unit } (clause { $clause }).
segments-environment-not-recorded = Air temperature and humidity were not both recorded: whether clause { $clause } was met is not known.
segments-without-rows = { $count } labelled segments have too few rows and were left out: { $listed }.
segments-null-rows = The { $triad } triad was left out of { $count } segments for their null rows: { $listed }.
segments-table-gap = The table stream does not cover { $count } segments, of which the labels alone give the attitude and rate: { $gaps }.
segments-table-gap-from = { $segment } from t = { $time } s
