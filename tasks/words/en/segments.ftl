## Checks of a recording's segments. $segment: its name; $channel: a column of the unit's stream.

segments-position-contradicted = { $segment }: labelled { $label } up, but accel_{ $axis } reads { $reading } m/s²: { $taken }.
segments-gravity-used = gravity shows { $up } up, and that was used
segments-no-axis-up = no axis lies within 10° of what is read; it was left out
segments-table = the table
segments-rate-contradicted = { $segment }: labelled { $label } deg/s about { $axis }, but { $witness } shows { $shown } deg/s: { $taken }.
segments-table-rate-used = the table's rate was used
segments-left-out = it was left out
segments-unsteady-rate = { $segment }: by { $witness } the rate changed by { $wander } deg/s during the segment; { $clause } asks for a steady rate ({ $percent } %).
segments-corrupted-rows = { $segment }: { $out } of { $rows } rows far from the rest ({ $channels }) were left out of the mean.
segments-disturbed = { $segment }: { $out } of { $rows } rows far from the rest ({ $channels }) were left out of the mean; { $burst } of them in a row: it was disturbed.
segments-stuck = { $segment }: { $channel } stood still at { $value } for { $rows } rows from t = { $time } s.
segments-lost-samples = { $segment }: { $lost } samples lost in { $gaps } gaps, the longest { $longest } s at t = { $time } s.
segments-short-dwell = { $short } of { $held } segments last less than the { $asked } s that { $clause } asks for at each point: { $listed }.
segments-coarse-step = The output's step is larger than its noise ({ $steps }, SI units): no averaging removes it, a mean may be off by half a step.
segments-overlapping = Segments overlap, so the same samples are counted twice: { $pairs }.
segments-overlapping-more = Segments overlap, so the same samples are counted twice: { $pairs } and { $more } more pairs.
segments-pair = { $first } and { $second }
segments-environment = { $segment }: { $quantity } { $worst } { $unit } is outside { $low } to { $high } { $unit } (clause { $clause }).
segments-temperature = air temperature
segments-humidity = relative humidity
segments-environment-not-recorded = Air temperature and humidity were not both recorded: whether clause { $clause } was met is not known.
segments-without-rows = { $count } labelled segments have too few rows and were left out: { $listed }.
segments-null-rows = The { $triad } triad was left out of { $count } segments for their null rows: { $listed }.
segments-table-gap = The table stream does not cover { $count } segments, of which the labels alone give the attitude and rate: { $gaps }.
segments-table-gap-from = { $segment } from t = { $time } s
