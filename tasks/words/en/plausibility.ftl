## What a recording cannot be, each in one sentence. $option: that of mimucal import.

plausibility-time = { $what ->
        [labels] The times of the labels reach to { $value }, which is { $factor } times too long beside the recording
       *[other] The time runs { $factor } times too long (rows are { $value } s apart)
    }: { $unit ->
        [ms] milliseconds
        [us] microseconds
       *[ns] nanoseconds
    }? Import it with { $option }.
plausibility-gravity-removed = The accelerometers read { $read } m/s² at rest: gravity was removed from them; record their readings before that is done.
plausibility-force-unit = The accelerometers read { $read } m/s² at rest, { $ratio } times local gravity ({ $gravity } m/s²): they look like { $unit }; import them with { $option }.
plausibility-rate-unit = The gyros read { $ratio } of the { $source ->
        [table] rates that the encoders show
        [gravity] angles by which gravity turns between the rests
       *[labels] rates that the labels state
    }: they look like { $unit }; import them with { $option }{ $source ->
        [labels] , or write rate_deg_s in deg/s if the labels are wrong
       *[other] {""}
    }.
plausibility-table-unit = The encoders turn { $ratio } times as far as the gyros: they look like degrees; import them with { $option }.
plausibility-axes = The axes are not those of the labels or the table: { $reads } ({ $value }); import it with { $option }.
plausibility-inverted = { $triad ->
        [gyro] gyro { $axes } inverted
        [accel] accelerometer { $axes } inverted
       *[both] { $axes } of gyros and accelerometers inverted
    }
plausibility-exchanged = { $triad ->
        [gyro] gyros { $axes } are exchanged
        [accel] accelerometers { $axes } are exchanged
       *[both] { $axes } are exchanged in gyros and accelerometers
    }
plausibility-turned = { $triad ->
        [gyro] the gyros are turned as a whole
        [accel] the accelerometers are turned as a whole
       *[both] the unit is turned as a whole, gyros and accelerometers together
    }, reading { $map }
plausibility-mirrored = { $triad ->
        [gyro] the axes of the gyros are exchanged and inverted
        [accel] the axes of the accelerometers are exchanged and inverted
       *[both] the axes of gyros and accelerometers alike are exchanged and inverted
    }, reading { $map }
plausibility-labels-shifted = All labels are { $seconds } s (± { $within } s) too { $late } in time; import the recording with { $option }.
