## What explain answers: the verdict, its findings, and the page of the report.

# Joints. The last full stop of a sentence stands in the sentence itself.
report-sentence = { $text }.
report-sentences = { $first } { $rest }
report-or = { $first } or { $rest }
report-one-of = { $effects }, which this recording does not tell apart

# Names.
report-whole-certificate = the certificate as a whole

# A finding in sentences.
report-what = { $title }{ $given ->
        [0] {""}
       *[other] : { $sizes }{ $more ->
            [0] {""}
           *[other] , and { $more } more
        } (k = 2)
    }.
report-parameter = { $name } = { $size }
report-factor = factor { $number } of the { $channel }
parameter-seconds = delay
report-place = { $channel } ({ $share }): { $description }
report-places = It sits in { $places }.
report-predicted = Segments that the fit did not see become { $times } as probable ({ $nats } nats)
report-not-predicted = Segments that the fit did not see are not predicted better ({ $nats } nats)
report-times = { $number } times
report-more-than-times = more than { $number } times
report-why = It removes { $share } of the mismatch above noise. { $prediction }; ΔBIC = { $bic }: { $evidence }, with its parameters paid for.
report-why-absorbed = The standard's parameters absorb it whole: it shows in their values, not in what is left over. ΔBIC = { $bic }: { $evidence }, with its parameters paid for.
report-nothing-removes = No effect of the catalogue and no pattern that was looked for removes it; in χ² per degree of freedom (noise of unit and reference: 1) there stays: { $channels }.
report-evidence-very-strong = very strong evidence
report-evidence-strong = strong evidence
report-evidence-some = some evidence
report-evidence-none = no evidence by this measure
report-stays-high = But with it χ² per degree of freedom of the { $channel } stays at { $chi2 } (noise of unit and reference: 1): more is missing there, or the reference is no finer. Evidence and U are counted against what is left, and its size may change when that is found.
report-homogeneity = Its parameters { $alike ->
        [0] differ between independent parts of the recording by more than chance ({ $p }){ $named ->
            [0] : no law of this form holds throughout, and U covers the scatter
           *[1] , but not by enough to take its name away; U covers the scatter
        }
       *[1] agree between independent parts of the recording ({ $p })
    }.
report-group = These make up for each other in this recording, and any of them fits within what is left: { $effects }{ $shared ->
        [0] {""}
       *[other] {""}. What they have in common is { $common } (k = 2)
    }.
report-alternatives = This recording cannot tell it from { $effects }.
report-no-alternatives = No other effect of the catalogue that was tried fits this recording as well.
report-to-record = To be sure, record: { $recording }.
report-moves-most = Of the certificate it moves most: { $element }, from { $before } with it left out to { $after } with it taken into account (k = 2), { $times } U.
report-moves-in-set = By itself it would move one value of the certificate, { $element }, by { $times } U, but other findings take that back: all together they move it by { $together } U, and only that counts.
report-to-do = Next: { $next }.
report-verdict-changes = The verdict on { $item } changes from { $before } to { $after }.

# What has no name.
report-without-name = without a name: { $pattern }
report-pattern = { $pattern }, in the { $channels }
report-refused-implausible = As «{ $effect }» its { $parameter } would be { $value }, { $larger ->
        [0] beyond { $limit }, the limit of what a working unit or station has
       *[1] { $times } times larger than in any working unit or station (at most { $limit })
    }, so it is not called that; such a size usually means { $usual }.
report-usual = { $kind ->
        [time] a time stamp in another unit (ms for s), or two streams that were not recorded together
        [length] a length in another unit (mm for m), or axes exchanged or inverted
        [angle] an attitude that is stated wrongly, deg for rad, or axes exchanged or inverted
        [alike] another cause of the same course
       *[scale] a range or unit set wrong (deg for rad, g for m/s², counts per unit), or axes exchanged or inverted
    }
report-refused-inhomogeneous = It behaves like «{ $effect }», but its size is not the same throughout: { $parameter } changes from { $smallest } to { $largest } { $parts ->
        [rate] between small and large rates
        [up] with the axis that is up
        [triad] between gyros and accelerometers
        [axis] from axis to axis
       *[time] in the course of the run
    }, which one law would not do; so it is not called that.
report-refused-channel = It behaves like «{ $effect }», but the { $channel }, which that would change as well, is predicted worse with it; so it is not called that.
report-refused-undetermined = It behaves like «{ $effect }», but no parameter of that would be larger than its U ({ $parameter } = { $value }, U = { $limit }): this recording does not determine it.
report-refused-reference-noise = It behaves like «{ $effect }», but the errors of the reference by themselves would bring forth as much of it, so it is not called that.
report-refused-placed = It behaves like «{ $effect }», but labels alone tell where the unit was put, and that has a parameter for everything that { $placed } rests leave: errors of placing would look the same; so it is not called that.
report-refused-overshadowed = It behaves like «{ $effect }», but what nothing explains in its channels is { $times } times as large as what that would remove, and may well contain it; so it is not called that.
report-refused-form-error = It behaves like «{ $effect }», but another finding has { $times } times its evidence, and a form a little different from its equation would leave as much; so it is not called that.
report-refused-incomplete = It behaves like «{ $effect }», but its channels still keep { $times } times the noise (χ² per degree of freedom): something else is at work, and this may be a part of it; so it is not called that.

# What to do about it.
report-next-implausible = check whether there is { $usual }; correct that, and explain again
report-next-alike = see whether unit and reference are joined stiffly (fixture, shaft, coupling), which filter stands before the output, and whether the reference itself is right; then record the same motion at half and at twice the speed
report-next-inhomogeneous = { $parts ->
        [rate] record the same motion at three or more speeds: how the size follows the rate tells which physics it is
        [up] repeat the motion with each axis up, and look at the mounting and the cables as the attitude changes
        [triad] compare how gyros and accelerometers are filtered and stamped: their output rates, low-passes and time stamps
        [axis] compare the settings of the axes: range, filter, order of sampling, and how each is mounted
       *[time] look in the log for what changed during the run (settings, temperature, mounting), and repeat its first part at the end
    }
report-next-channel = check sign, scale and filter of the { $channel }, and record the same motion about another axis
report-next-undetermined = record what would determine it: { $recording }
report-next-reference-noise = repeat with a finer or smoother encoder: this one's noise hides what the unit does
report-next-placed = put the unit into each position a second time, or record its attitude (encoders, a tracked pose): what comes again with the attitude is a law, what does not is placing
report-next-overshadowed = find what is left in these channels first: it is much larger; then explain again
report-next-incomplete = look at what is left in these channels segment by segment: something with a law of its own is among it; then explain again
report-next = { $dimension ->
        [rate] record steady rates of both signs in at least five steps, and see whether what is left grows with the rate, its size or its square
        [attitude] record rests with each axis up, down and at 45 deg at two headings, and look at what changes with attitude: cables, clamping, magnets nearby
        [rotation_phase] turn slowly through whole turns both ways, with the unit at two places on the payload: what keeps its place on the shaft is the table's
        [frequency] record a rest with the drive on and off, and one at another sample rate: what stops with the drive is vibration, what moves is an alias
        [temperature] record rests at three steady temperatures, each reached warming and cooling
        [time] look in the log for what happened then, and run again: what does not come again at the same time is no matter of the motion
        [after_moves] let each rest last five times as long, reached from both sides, and watch the fixture settle
        [ramps] record ramps of three accelerations with one trigger seen by both clocks, and look up how the unit filters and stamps its output
        [recorded] vary that quantity alone while the unit rests
       *[level] record a rest of an hour and a few plain rates: what is there at rest is noise or drift, the rest is a response to motion
    }

# The verdict.
report-summary = { $kinds ->
        [none] Nothing of the mismatch above noise has a name: { $unnamed } of it follows patterns that nothing in the catalogue explains, { $left } follows none
        [some] { $all } of the mismatch above noise is accounted for ({ $named } by effects with a name, { $unnamed } by patterns without one), { $left } is not
       *[all] { $all } of the mismatch above noise is explained, { $left } is not
    }; look first at: { $first }.
report-first-left = what is left in the { $channel } (χ² = { $chi2 } per degree of freedom)
report-left = What is left stands above the unit's noise and that of the reference, in χ² per degree of freedom: { $channels }.
report-left-in = { $channel } { $chi2 }
report-small = Small remainders: { $remainders }.
report-small-finding = { $title } ({ $share })
report-no_mismatch = no mismatch
    .headline = No mismatch: the standard's model accounts for this recording
report-explained = explained
    .headline = Explained: what the standard's model leaves out is found
report-partly_explained = partly explained
    .headline = Partly explained: something is found, something stays without a name
report-unexplained = unexplained
    .headline = Unexplained: model and recording differ, and nothing in the catalogue accounts for it
report-nothing-found = Nothing was found that the standard's model leaves out. On segments that the fit did not see it leaves χ² = { $chi2 } per degree of freedom (noise alone: 1). What is smaller than the noise lets see, or what the standard's parameters absorb whole, this recording cannot show.
report-tested = Tested were { $channels } channels over { $minutes } min at { $rate } Hz{ $kinds ->
        [0] {""}
       *[other] {" "}with { $segments }
    }.
report-static-segments =
    { $count ->
        [one] { $count } rest
       *[other] { $count } rests
    }
report-rate-segments =
    { $count ->
        [one] { $count } constant rate
       *[other] { $count } constant rates
    }
report-rotation-segments =
    { $count ->
        [one] { $count } turn by a known angle
       *[other] { $count } turns by a known angle
    }
report-detected = The strongest departure from the standard's model has { $p }, corrected for how many were looked for; a mismatch is stated below p = { $limit }, which one clean recording in { $odds } reaches by chance.
report-left-out = The standard's model leaves out: { $findings }.
report-left-out-size = { $title } ({ $size })
report-unnamed = { $verdict ->
        [partly_explained] A part of the excess
       *[unexplained] What model and recording differ by
    } is explained by nothing in the catalogue, and is given no name{ $described ->
        [0] {""}
       *[other] ; what is seen: { $follows }
    }.
report-gained = On segments that the fit did not see, χ² per degree of freedom goes from { $before } to { $after } (noise of unit and reference: 1).
report-gained-most = On segments that the fit did not see, χ² per degree of freedom goes from { $before } to { $after } (noise of unit and reference: 1), and the rms residual of the { $channel } falls to { $share }.
report-moved = { $findings ->
        [one] Taking it into account
       *[other] Taking all findings into account together
    } moves { $values ->
        [0] no values
        [one] { $values } value
       *[other] { $values } values
    } of the certificate by more than U{ $verdicts ->
        [0] {""}
        [one] {" "}and changes { $verdicts } verdict
       *[other] {" "}and changes { $verdicts } verdicts
    }, most of all { $element }: { $before } → { $after } ({ $times } U).

# The page.
report-title = Model and recording: { $recording }
report-shares =
    .caption = Left: share of the mismatch above noise that each finding removes, and what none of them explains. Right: χ² per degree of freedom of what is left in each channel, against the noise of unit and reference (noise alone: 1).
report-where = Where
    .caption = Colour: by how many standard deviations the misfit of the standard's model stands above noise, at the averaging time at which it shows most. The strip above tells rests, rates and turns; bars below a channel tell in which segments a finding sits, the numbers at the right its share.
    .caption-noise = Colour: by how many standard deviations the misfit of the standard's model stands above white noise, at the averaging time at which it shows most. Single pale cells are the unit's own slow noise: all in all there is no more than chance allows.
report-what-was-left-out = What was left out
report-before-after = Before and after
    .caption = Left: means of the residual over time; pale bars show what swings within a cell. Right: spectrum of the residual divided by the noise of a sample.
report-left-over = What is left over
    .caption = Left: means of the residual over time. Right: spectrum of the residual divided by the noise of a sample; a rise at low frequencies is the flicker and drift of the unit's own noise.
report-held-out = Segments that the fit did not see: χ² per degree of freedom { $before } before, { $after } after (noise of unit and reference: 1).
report-rms-ratio = rms residual, after / before
report-certificate = The certificate
report-nothing-moved = No value of the certificate was found to be moved.
report-remarks = Remarks
report-method = Method and false alarms
    .compared = The readings are compared with models (1) and (2) of JJF 2003-2022, driven by the motion that the table reports and by the gravity that the recording tells: no Earth rotation, no lever arm, a perfect vertical, no temperature, no delay. Every effect of the catalogue is added in turn and all parameters are fitted again together; what is added must predict stretches that its fit did not see.
report-origin = Origin
    .recording = recording
    .digest = digest of its content (SHA-256)
    .model = compared with
    .unit = unit
    .station = station
    .code = made with
    .data = as data

# Heads of the cards and tables.
report-card-size = How large
report-card-refused = Why it has no name
report-card-equation = Equation
report-card-why = Why we believe it
report-card-tests = What else was tested
report-card-alternatives = Could also be
report-card-record = To be sure, record
report-card-certificate = On the certificate
report-card-next = What to do next
report-together = all
report-column-number = no.
report-column-parameter = parameter
report-column-value = value
report-column-uncertainty = U (k = 2)
report-column-unit = unit
report-column-channel = channel
report-column-share = share
report-column-where = where
report-column-along = along
report-column-segments = segments
report-column-element = value of the certificate
report-column-before = left out
report-column-after = taken into account
report-column-change = change / U
report-change = { $before } → { $after }
report-column-verdict = verdict
report-dimension-rate = rate
report-dimension-attitude = attitude
report-dimension-rotation_phase = phase of the turn
report-dimension-frequency = frequency
report-dimension-temperature = temperature
report-dimension-time = time
report-dimension-after_moves = after moves
report-dimension-ramps = ramps
report-dimension-recorded = a recorded quantity
report-dimension-level = everywhere alike
