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
plausibility-force-unit = The accelerometers read { $read } m/s² at rest, { $ratio } times local gravity ({ $gravity } m/s²): { $advised ->
        [yes] they look like { $unit }, which that is to { $off } %; import them with { $option }
       *[no] no usual unit of specific force reads that in all rests and with such numbers; look at their range, their counts and their columns
    }.
plausibility-force-setting = The accelerometers read { $read } m/s² at rest, { $ratio } times local gravity ({ $gravity } m/s²), on all axes alike: no unit's own scale factors are all so far from one; a range, or the counts per g, is set wrong in the logger.
plausibility-rate-setting = The gyros read { $ratio } of the { $source ->
        [table] rates that the encoders show
        [pose] rates that the poses show
       *[labels] rates that the labels state
    }, on all axes alike: no unit's own scale factors are all so far from one; a range, or the counts per °/s, is set wrong in the logger.
plausibility-rate-unit = The gyros read { $ratio } of the { $source ->
        [table] rates that the encoders show
        [pose] rates that the poses show
        [gravity] angles by which gravity turns between the rests
       *[labels] rates that the labels state
    }: { $advised ->
        [yes] they look like { $unit }, which that is to { $off } %; import them with { $option }{ $source ->
            [labels] , or write rate_deg_s in deg/s if the labels are wrong
           *[other] {""}
        }
       *[no] no usual unit of rate is that with such numbers; look at their range, their counts and their columns
    }.
plausibility-table-unit = The encoders turn { $ratio } times as far as the gyros: they look like degrees; import them with { $option }.
plausibility-label-unit = rate_deg_s of { $count } { $count ->
        [one] segment
       *[other] segments
    } is in the wrong unit: { $segment } says { $label } deg/s, and the gyros read { $read } deg/s, a factor of 57.3; write rate_deg_s in deg/s and the gyros in rad/s, or import with --units.
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
plausibility-mount = The unit is turned by { $degrees }° about ({ $axis }) against the axes that the labels or the table name, gyros and accelerometers alike: no exchange of axes is that; lay it along the axes, or state its mount in the recording.
plausibility-columns = Columns are not what they are called ({ $what }): fields may lie one too far, or columns be exchanged; say which is which by --columns.
plausibility-column-follows = { $channel } follows gravity at rest as an accelerometer does
plausibility-column-nothing = { $triad ->
        [gyro] the gyros read nothing of the rates about { $axis }
       *[accel] the accelerometers read nothing of gravity along { $axis }
    }
plausibility-coarse-log = The { $sensors ->
        [gyro] gyros
       *[accel] accelerometers
    } stood at one code { $count ->
        [one] once
       *[other] { $count } times
    }, in { $segments } of { $of } segments: their step of { $step } { $sensors ->
        [gyro] rad/s
       *[accel] m/s²
    } is wider than their noise; log more digits, or set a smaller range.
plausibility-held-rows = { $listed }: up to { $share } % of the rows repeat the { $sensors ->
        [gyro] gyros
       *[accel] accelerometers
    }' reading of the row before ({ $usual } % usually): they were held while the unit moved so, as by a full scale that adapts; { $count ->
        [one] this segment is suspect
       *[other] these segments are suspect
    }.
seen-no-data = { $count } of { $rows } rows hold a mark of no data in place of the { $sensors ->
        [gyro] gyros' readings
       *[accel] accelerometers' readings
    } ({ $mark }): left out.
seen-copies = { $others } { $rows ->
       *[other] repeat { $first } in all { $rows } rows
    }: one column was logged more than once, and which it is, it does not tell; the { $sensors ->
        [gyro] gyros
       *[accel] accelerometers
    } were left out. Log each axis.
seen-clock-set = The clock was set { $count ->
        [one] {""}
       *[other] { $count } times, first{" "}
    }{ $way ->
        [ahead] ahead
       *[back] back
    } before line { $line } (by { $seconds } s) with no row missing: its steps were taken out.
seen-restarted = The unit or its logger began anew before line { $line }: { $known ->
        [labels] by the labels after it { $seconds } s (± { $within } s) passed that nobody logged, and the rows after it were moved by that
       *[no] how long it was off nothing tells, and rows go on at once
    }. Before and after it are two turn-ons, which share no bias{ $left ->
        [none] {""}
       *[other] ; left out: { $left }
    }. Calibrate each on its own, or record again.
plausibility-offset-binary = The { $sensors ->
        [gyro] gyros read { $read } rad/s
       *[accel] accelerometers read { $read } m/s²
    } where nothing acts, half of their range: { $codes } codes were never taken off (offset binary); they are taken off here.
