## Checks of a recording's segments. $segment: its name; $channel: a column of the unit's stream.

validity-position-contradicted = { $segment }: labelled { $label } up, but accel_{ $axis } reads { $reading } m/s²: { $shown ->
        [none] no axis lies within 10° of the measured gravity; the segment was excluded
       *[other] gravity shows { $shown } up, which was used instead
    }.
validity-rate-contradicted = { $segment }: labelled { $label } deg/s about { $axis }, but { $witness ->
        [table] the table
       *[other] { $witness }
    } shows { $shown } deg/s: { $witness ->
        [table] the table's rate was used
       *[other] the segment was excluded
    }.
validity-unsteady-rate = { $segment }: according to { $witness ->
        [table] the table
       *[other] { $witness }
    } the rate changed by { $wander } deg/s during the segment; { $clause } requires a constant rate ({ $percent } %).
validity-corrupted-rows = { $segment }: { $out } of { $rows } outlying rows ({ $channels }) were excluded from the mean.
validity-disturbed = { $segment }: { $out } of { $rows } rows ({ $channels }) are outliers and were excluded from the mean, { $burst } of them consecutive: the segment was disturbed.
validity-stuck = { $segment }: { $channel } was stuck at { $value } for { $rows } rows from t = { $time } s.
validity-lost-samples = { $segment }: { $lost } samples lost in { $gaps ->
        [one] 1 gap
       *[other] { $gaps } gaps
    }, the longest { $longest } s at t = { $time } s.
validity-short-dwell = { $short } of { $held } segments are shorter than the { $asked } s per point required by { $clause }: { $listed }.
validity-coarse-step = The resolution of the output is coarser than its noise ({ $steps }, in rad/s for gyros and m/s² for accelerometers): averaging cannot reduce it, and a mean may be off by half a step.
validity-overlapping-segments = Segments overlap, so some samples are counted twice: { $more ->
        [0] { $pairs }
        [one] { $pairs } and 1 more pair
       *[other] { $pairs } and { $more } more pairs
    }.
validity-pair = { $first } and { $second }
validity-environment = { $segment }: { $quantity ->
        [temperature] air temperature
       *[humidity] relative humidity
    } { $worst } { $unit } is outside { $low } to { $high } { $unit } (clause { $clause }).
validity-environment-not-recorded = Air temperature and humidity were not both recorded, so compliance with clause { $clause } is unknown.
validity-without-rows = { $count ->
        [one] 1 labelled segment contains too few rows and was
       *[other] { $count } labelled segments contain too few rows and were
    } excluded: { $listed }.
validity-null-rows = The { $triad } triad was excluded from { $count ->
        [one] 1 segment
       *[other] { $count } segments
    } because of missing values: { $listed }.
validity-table-gap = The table stream does not cover { $count ->
        [one] 1 segment, the attitude and rate of which come
       *[other] { $count } segments, the attitude and rate of which come
    } from labels alone: { $gaps }.
validity-table-gap-from = { $segment } from t = { $time } s

## Checks of the whole run.

validity-no-reference = Neither encoders nor a pose were recorded: the rate of { $count ->
        [one] 1 turn
       *[other] { $count } turns
    } is known from labels alone.
validity-angle-contradicted = { $segment }: labelled as a turn by { $label }°, but the encoders show { $shown }°.
validity-rest-turns = { $count ->
        [one] 1 segment labelled as rest ({ $first }) is
       *[other] { $count } segments labelled as rests ({ $first } first) are
    } not at rest: the table turns, or a gyro reads a different rate from that in the other rests.
validity-encoder-jump = The encoder of axis { $axis } jumps { $count ->
        [one] once
       *[other] { $count } times
    }, by up to { $size }° at t = { $time } s, faster than any table can turn.
validity-attitude-contradicted = In { $count ->
        [one] 1 rest ({ $first })
       *[other] { $count } rests ({ $first } first)
    } the direction of gravity in the unit disagrees with the encoders by up to { $left } m/s²; { $limit } m/s² is allowed.
validity-gyro-contradicts-encoder = In { $count ->
        [one] 1 segment turning about { $axis } ({ $first })
       *[other] { $count } segments turning about { $axis } ({ $first } first)
    } the ratio of gyro to encoder rate differs by more than { $percent } % from that in the others.
validity-input-axis = In the segments turning about { $axis }, gyro { $gyro } follows the rate with a factor of { $gain }: the unit is not mounted as the manifest states, or channels or signs are swapped.
validity-latitude-not-given = The latitude is not stated, so gravity and Earth's rotation could not be checked against it.
validity-laboratory-latitude = The recording states a latitude of { $latitude }°, but that of the laboratory is { $own }°.
validity-gravity-not-given = The local gravity is not stated.
validity-gravity-contradicted = The local gravity is stated as { $gravity } m/s², but at { $latitude }° latitude and { $lowest } to { $highest } m altitude it is { $low } to { $high } m/s².
validity-earth-not-shown = The rests do not show the horizontal component of Earth's rotation: { $north } of it along north and { $east } along east (u = { $u }), where { $expected } along north is expected at { $latitude }° latitude; latitude or heading may be wrong, or the data are compensated.
validity-earth-contradicted = The rests show an Earth rotation that contradicts latitude and heading: { $north } of it along north and { $east } along east (u = { $u }), where { $expected } along north is expected at { $latitude }° latitude.
validity-latitude-sign = The rests show { $shown } of Earth's rotation upwards (u = { $u }), where { $expected } is expected at { $latitude }° latitude: the latitude has the wrong sign.
validity-samples-off = { $channel }: { $share } % of the samples deviate by more than { $off } standard deviations from the rest of their segment; { $limit } % is allowed.
validity-vibration = { $channel }: in { $count ->
        [one] 1 rest ({ $first })
       *[other] { $count } rests ({ $first } first)
    } the standard deviation of the readings reaches { $deviation }; { $limit } is allowed (rad/s for a gyro, m/s² for an accelerometer): the unit was vibrated.
validity-drift = { $channel }: { $segment } deviates by { $left } { $unit } from the other rests, which U = { $U } { $unit } does not cover: the zero drifted or jumped.
validity-unsteady-zero = { $channel }: { $segment } deviates by { $left } from the other rests; { $limit } is allowed (rad/s for a gyro, m/s² for an accelerometer): the zero drifted or jumped.
validity-lost-share = { $share } % of the samples of the { $stream } stream are missing within the segments; { $limit } % is allowed.
validity-time-base = By the times of the recording the table turned by { $off }×10⁻⁶ otherwise than it was set to, at all { $count } rates alike; { $limit }×10⁻⁶ is allowed: check the clock that stamps the readings, or the table's.
validity-clocks-apart = The clocks of unit and table differ by up to { $delay } s; { $limit } s is allowed.
validity-environment-in-part = { $quantity ->
        [temperature] Air temperature
       *[humidity] Relative humidity
    } was not recorded in { $count } of { $of } segments ({ $first } first), so clause { $clause } may not have been met.
validity-unit-temperature-not-recorded = The unit's own temperature was not recorded in { $count } of { $of } segments.
validity-follows-temperature = { $channel } follows the recorded temperature of the unit, which changed by { $change } K: its gain by { $gain } ppm/K, its zero by { $zero } { $unit } per K. Each element holds at the temperature given with it.
validity-unit-temperature-changed = The unit's own temperature ranged from { $low } to { $high } °C during the measurement; a change of { $limit } K is allowed.
validity-unit-temperature-level = The unit's own temperature is { $level } °C at an air temperature of { $air } °C; { $cooler } K below to { $warmer } K above the air is allowed.
validity-supply-not-recorded = The supply voltage of the unit was not recorded in { $count } of { $of } segments.
validity-supply-level = The supply voltage of the unit is { $level } V, outside the plausible { $low } to { $high } V.
validity-supply-changed = The supply voltage of the unit ranged from { $low } to { $high } V around { $usual } V; ±{ $percent } % is allowed.
validity-beyond-recording = { $segment } is labelled from { $start } to { $end } s, but the samples reach from { $first } to { $last } s: its times are wrong, or the recording was cut off.
validity-misspelt-field = Field { $field } of the manifest is unknown and was not used; { $meant } is absent: correct the spelling if it was meant.
validity-station-remarks-unreadable = The station's remarks, field { $field } of the manifest, cannot be read.
