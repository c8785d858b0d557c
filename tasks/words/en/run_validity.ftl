## Checks of a recording's segments. $segment: its name; $channel: a column of the unit's stream.

validity-position-contradicted = { $segment }: labelled { $label } up, but accel_{ $axis } reads { $reading } m/s²: { $shown ->
        [none] no axis lies within 10° of what is read; it was left out
       *[other] gravity shows { $shown } up, and that was used
    }.
validity-rate-contradicted = { $segment }: labelled { $label } deg/s about { $axis }, but { $witness ->
        [table] the table
       *[other] { $witness }
    } shows { $shown } deg/s: { $witness ->
        [table] the table's rate was used
       *[other] it was left out
    }.
validity-unsteady-rate = { $segment }: by { $witness ->
        [table] the table
       *[other] { $witness }
    } the rate changed by { $wander } deg/s during the segment; { $clause } asks for a steady rate ({ $percent } %).
validity-corrupted-rows = { $segment }: { $out } of { $rows } rows far from the rest ({ $channels }) were left out of the mean.
validity-disturbed = { $segment }: { $out } of { $rows } rows far from the rest ({ $channels }) were left out of the mean; { $burst } of them in a row: it was disturbed.
validity-stuck = { $segment }: { $channel } stood still at { $value } for { $rows } rows from t = { $time } s.
validity-lost-samples = { $segment }: { $lost } samples lost in { $gaps } gaps, the longest { $longest } s at t = { $time } s.
validity-short-dwell = { $short } of { $held } segments last less than the { $asked } s that { $clause } asks for at each point: { $listed }.
validity-coarse-step = The output's step is larger than its noise ({ $steps }, SI units): no averaging removes it, a mean may be off by half a step.
validity-overlapping-segments = Segments overlap, so the same samples are counted twice: { $more ->
        [0] { $pairs }
       *[other] { $pairs } and { $more } more pairs
    }.
validity-pair = { $first } and { $second }
validity-environment = { $segment }: { $quantity ->
        [temperature] air temperature
       *[humidity] relative humidity
    } { $worst } { $unit } is outside { $low } to { $high } { $unit } (clause { $clause }).
validity-environment-not-recorded = Air temperature and humidity were not both recorded: whether clause { $clause } was met is not known.
validity-without-rows = { $count } labelled segments have too few rows and were left out: { $listed }.
validity-null-rows = The { $triad } triad was left out of { $count } segments for their null rows: { $listed }.
validity-table-gap = The table stream does not cover { $count } segments, of which the labels alone give the attitude and rate: { $gaps }.
validity-table-gap-from = { $segment } from t = { $time } s

## Checks of the whole run.

validity-no-reference = Neither encoders nor a pose were recorded: of { $count } turns the labels alone tell how fast they were.
validity-angle-contradicted = { $segment }: labelled a turn by { $label }°, but the encoders turned by { $shown }°.
validity-rest-turns = { $count } rests are none ({ $first } first): the table turns, or a gyro reads another rate than in the others.
validity-encoder-jump = The encoder of axis { $axis } jumps { $count } times, by up to { $size }° at t = { $time } s, as no table turns.
validity-attitude-contradicted = In { $count } rests ({ $first } first) gravity lies otherwise in the unit than the encoders have it, by up to { $left } m/s² where { $limit } m/s² is allowed.
validity-gyro-contradicts-encoder = In { $count } runs about { $axis } ({ $first } first) the gyro follows the encoders by more than { $percent } % otherwise than in the rest.
validity-input-axis = In the runs about { $axis } it is gyro { $gyro } that follows the rate, by { $gain } times: the unit is mounted otherwise than the manifest says, or its channels or signs are changed.
validity-latitude-not-given = The latitude is not stated: gravity and Earth's rotation could not be checked against it.
validity-laboratory-latitude = The recording states { $latitude }° latitude, but the laboratory is at { $own }°.
validity-gravity-not-given = The local gravity is not stated.
validity-gravity-contradicted = The local gravity is stated as { $gravity } m/s², but at { $latitude }° latitude, { $lowest } to { $highest } m high, it is { $low } to { $high } m/s².
validity-earth-not-shown = The rests do not show the level part of Earth's rotation: { $north } of it along north and { $east } along east (u = { $u }) where { $latitude }° latitude has { $expected } along north; latitude or heading may be wrong, or the data are compensated.
validity-earth-contradicted = The rests show Earth's rotation otherwise than latitude and heading have it: { $north } of it along north and { $east } along east (u = { $u }) where { $latitude }° latitude has { $expected } along north.
validity-latitude-sign = The rests show { $shown } of Earth's rotation upwards (u = { $u }) where { $latitude }° latitude has { $expected }: the latitude has the wrong sign.
validity-samples-off = { $channel }: { $share } % of the samples are more than { $off } standard deviations off the rest of their segment; { $limit } % are allowed.
validity-vibration = { $channel }: in { $count } rests ({ $first } first) the readings scatter by up to { $deviation } where { $limit } is allowed (SI units): the unit was shaken.
validity-drift = { $channel }: { $segment } is { $left } { $unit } off what the other rests have, which U = { $U } { $unit } does not cover: the zero drifted or jumped.
validity-unsteady-zero = { $channel }: { $segment } is { $left } off what the other rests have where { $limit } is allowed (SI units): the zero drifted or jumped.
validity-lost-share = { $share } % of the samples of the { $stream } stream are missing in the segments; { $limit } % are allowed.
validity-clocks-apart = Unit and table are up to { $delay } s apart in time; { $limit } s are allowed.
validity-environment-in-part = { $quantity ->
        [temperature] Air temperature
       *[humidity] Relative humidity
    } was not recorded over the whole run: not in { $count } of { $of } segments ({ $first } first), so that clause { $clause } may not have been met.
validity-unit-temperature-not-recorded = The unit's own temperature was not recorded over the whole run: not in { $count } of { $of } segments.
validity-unit-temperature-changed = The unit's own temperature went from { $low } to { $high } °C while it was measured; a change of { $limit } K is allowed.
validity-unit-temperature-level = The unit's own temperature is { $level } °C in air of { $air } °C; from { $cooler } K below it to { $warmer } K above it is allowed.
validity-supply-not-recorded = The unit's supply was not recorded over the whole run: not in { $count } of { $of } segments.
validity-supply-level = The unit's supply is { $level } V; { $low } to { $high } V is what a unit may need.
validity-supply-changed = The unit's supply went from { $low } to { $high } V about its usual { $usual } V; ±{ $percent } % is allowed.
validity-station-remarks-unreadable = What the station noticed, { $field } of the manifest, cannot be read.
