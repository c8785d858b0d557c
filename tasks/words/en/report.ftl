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
parameter-seconds = delay of the unit behind the reference (negative: the reference is late)
parameter-of-rms = rms of the { $channel } within the run
parameter-of-rate = wander of the { $channel }
report-place = { $channel } ({ $share }): { $description }
report-places = It sits in { $places }.
report-predicted = Segments withheld from the fit become { $times } as probable ({ $nats } nats)
report-not-predicted = Segments withheld from the fit are predicted no better ({ $nats } nats)
report-times = { $number } times
report-more-than-times = more than { $number } times
report-why = It removes { $share } of the mismatch above noise. { $prediction }; ΔBIC = { $bic }: { $evidence } after the penalty for its parameters.
report-why-over-many = It is too small, or too rare, to remove a share of the mismatch of single readings; it shows in all of them together. { $prediction }; ΔBIC = { $bic }: { $evidence } after the penalty for its parameters.
report-why-absorbed = The standard's parameters absorb it completely: it shows in their values, not in the residual. ΔBIC = { $bic }: { $evidence } after the penalty for its parameters.
report-nothing-removes = No catalogue effect and no pattern that was searched for removes it. Remaining χ² per degree of freedom (noise at rest and of the reference = 1): { $channels }.
report-evidence-very-strong = very strong evidence
report-evidence-strong = strong evidence
report-evidence-some = some evidence
report-evidence-none = no evidence on this scale
report-stays-high = Even so, χ² per degree of freedom of the { $channel } remains at { $chi2 } (noise at rest and of the reference = 1): something else is missing there, or the reference is not accurate enough. Evidence and U are scaled to this residual, and the size of the effect may change once its cause is found.
report-homogeneity = Its parameters { $alike ->
        [0] differ between independent parts of the recording by more than chance ({ $p }){ $named ->
            [0] : no law of this form holds throughout; U includes the scatter
           *[1] , but not by enough to withhold the name; U includes the scatter
        }
       *[1] agree between independent parts of the recording ({ $p })
    }.
report-group = These effects are confounded in this recording, and any of them fits within the residual: { $effects }{ $shared ->
        [0] {""}
       *[other] {""}. Their common part is { $common } (k = 2)
    }.
report-alternatives = This recording cannot distinguish it from { $effects }.
report-no-alternatives = No other catalogue effect that was tried fits this recording equally well.
report-to-record = To confirm, record: { $recording }.
report-moves-most = Largest change on the certificate{ $joint ->
        [0] {""}
        [one] , together with finding { $others }
       *[other] , together with findings { $others }
    }: { $element }, from { $before } without it to { $after } with it (± U), { $times } U (the larger of the two).
report-moves-in-set = { $joint ->
        [0] On its own
        [one] Together with finding { $others }
       *[other] Together with findings { $others }
    } it would change { $element } by { $times } U, but the other findings offset that: together they change it by { $together } U, which is what counts.
report-to-do = Next step: { $next }.
report-verdict-changes = The verdict on { $item } changes from { $before } to { $after }.

# What has no name.
report-without-name = unnamed: { $pattern }
report-pattern = { $pattern }, in the { $channels }
report-refused-implausible = As “{ $effect }” its { $parameter } would be { $value }, { $larger ->
        [0] beyond { $limit }, the limit for a working unit or station
       *[1] { $times } times larger than in any working unit or station (at most { $limit })
    }; the name is therefore withheld. Such a size usually indicates { $usual }.
report-usual = { $kind ->
        [time] a time stamp in the wrong unit (ms for s), or two streams that were not recorded together
        [length] a length in the wrong unit (mm for m), or swapped or inverted axes
        [angle] a wrong attitude, deg for rad, or swapped or inverted axes
        [alike] another cause with the same time history
       *[scale] a wrong range or unit setting (deg for rad, g for m/s², counts per unit), or swapped or inverted axes
    }
report-refused-inhomogeneous = It behaves like “{ $effect }”, but its size changes: { $parameter } ranges from { $smallest } to { $largest } { $parts ->
        [rate] between low and high rates
        [up] depending on which axis is up
        [triad] between gyros and accelerometers
        [axis] from axis to axis
       *[time] over the run
    }, which a single law would not do; the name is therefore withheld.
report-refused-channel = It resembles “{ $effect }”, but including it makes the prediction of the { $channel } worse, which that effect would also change; the name is therefore withheld.
report-refused-undetermined = It resembles “{ $effect }”, but none of that effect's parameters exceeds its U ({ $parameter } = { $value }, U = { $limit }): this recording does not determine it.
report-refused-reference-noise = It resembles “{ $effect }”, but errors of the reference alone could produce as much; the name is therefore withheld.
report-refused-placed = It resembles “{ $effect }”, but the unit's orientation is known from labels alone, and that effect has enough parameters to absorb all that the { $placed } rests leave: placement errors would look the same. The name is therefore withheld.
report-refused-switching = It resembles “{ $effect }”, but nearly all of its change lies at two moments, where a random walk changes throughout: a signal that switches to and fro looks like that; the name is therefore withheld.
report-refused-overshadowed = It resembles “{ $effect }”, but what stays unexplained in its channels (χ² per degree of freedom up to { $chi2 }, { $times } times what that effect removes) may well contain it; the name is therefore withheld.
report-refused-form-error = It resembles “{ $effect }”, but other findings weigh { $times } times as much, and a slight error in the form of their equations would leave as much; the name is therefore withheld.

# What to do about it.
report-next-implausible = check for { $usual }; correct it and run explain again
report-next-alike = check that unit and reference are rigidly connected (fixture, shaft, coupling), which filter precedes the output, and whether the reference itself is correct; then record the same motion at half and at twice the speed
report-next-inhomogeneous = { $parts ->
        [rate] record the same motion at three or more speeds: how the size depends on rate identifies the physics
        [up] repeat the motion with each axis up, and inspect mounting and cables as the attitude changes
        [triad] compare how gyros and accelerometers are filtered and time-stamped: output rates, low-pass filters, time stamps
        [axis] compare the settings of the axes (range, filter, sampling order) and their mounting
       *[time] check the log for changes during the run (settings, temperature, mounting), and repeat its first part at the end
    }
report-next-channel = check the sign, scale and filter of the { $channel }, and record the same motion about another axis
report-next-undetermined = make a recording that determines it: { $recording }
report-next-reference-noise = repeat with a finer or smoother encoder: the noise of this one masks the unit's behaviour
report-next-placed = place the unit in each position a second time, or record its attitude (encoders, a tracked pose): what repeats with attitude is a property of the unit, what does not is placement error
report-next-switching = look up what was switched or touched at these moments, and record a rest of several hours: what switches to and fro has two levels, a random walk has none
report-next-overshadowed = first find the cause of the residual in these channels; then run explain again
report-next = { $dimension ->
        [rate] record steady rates of both signs in at least five steps, and check whether the residual grows with the rate, its magnitude or its square
        [attitude] record rests with each axis up, down and at 45° at two headings, and check what changes with attitude: cables, clamping, nearby magnets
        [rotation_phase] turn slowly through full revolutions in both directions, with the unit at two places on the payload: what keeps its position on the shaft belongs to the table
        [frequency] record a rest with the drive on and off, and another at a different sample rate: what stops with the drive is vibration, what shifts is an alias
        [temperature] record rests at three stable temperatures, each approached by warming and by cooling
        [time] check the log for what happened at that time, and repeat the run: what does not recur at the same time is unrelated to the motion
        [after_moves] make each rest five times as long, approached from both sides, and observe how the fixture settles
        [ramps] record ramps at three accelerations with a trigger common to both clocks, and look up how the unit filters and time-stamps its output
        [recorded] vary that quantity alone while the unit is at rest
       *[level] record a rest, and the same motion at half and at twice the speed: what appears at rest is noise or drift, what grows with the speed is a response to motion
    }

# The verdict.
report-summary = { $kinds ->
        [none] No part of the mismatch above noise could be named: { $unnamed } of it follows patterns that no catalogue effect explains, { $left } follows none
        [some] { $all } of the mismatch above noise is accounted for ({ $named } by named effects, { $unnamed } by unnamed patterns), { $left } is not
        [absorbed] The residual shows no mismatch above noise, since the standard's parameters absorb what was left out
       *[all] { $all } of the mismatch above noise is explained, { $left } is not
    }; look first at: { $first }.
report-first-left = the residual of the { $channel } (χ² = { $chi2 } per degree of freedom)
report-left = The residual exceeds the noise of unit and reference; χ² per degree of freedom: { $channels }.
report-left-in = { $channel } { $chi2 }
report-small = Minor remainders: { $remainders }.
report-small-finding = { $title } ({ $share })
report-no_mismatch = no mismatch
    .headline = No mismatch: the standard's model accounts for this recording
report-explained = explained
    .headline = Explained: the physics missing from the standard's model was identified
report-partly_explained = partly explained
    .headline = Partly explained: one part was identified, another remains unnamed
report-unexplained = unexplained
    .headline = Unexplained: model and recording differ, and nothing in the catalogue accounts for the difference
report-invalid = As it was imported, this run is invalid:
report-nothing-found = No physics missing from the standard's model was found. On segments withheld from the fit, χ² per degree of freedom is { $chi2 } (noise alone: 1). Effects below the noise, or fully absorbed by the standard's parameters, cannot be seen in this recording.
report-tested = { $channels } channels were tested over { $minutes } min at { $rate } Hz{ $kinds ->
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
report-detected = The strongest departure from the standard's model has { $p }, corrected for the number of tests; a mismatch is reported below p = { $limit }, which one clean recording in { $odds } reaches by chance.
report-left-out = Missing from the standard's model: { $findings }.
report-left-out-size = { $title } ({ $size })
report-left-out-or = { $title }, or { $others }, which this recording cannot distinguish
report-unnamed = { $verdict ->
        [partly_explained] Part of the mismatch
       *[unexplained] The mismatch
    } is not explained by any effect in the catalogue and is left unnamed{ $described ->
        [0] {""}
       *[other] ; observed: { $follows }
    }.
report-gained = On segments withheld from the fit, χ² per degree of freedom { $change ->
        [level] is { $after }
        [rises] rises from { $before } to { $after }
       *[falls] falls from { $before } to { $after }
    } (1: the noise of the residual at high frequencies){ $most ->
        [0] {""}
       *[other] , and the rms residual of the { $channel } falls to { $share }
    }.
report-moved = { $findings ->
        [one] Taking it into account
       *[other] Taking all findings into account together
    } changes { $values ->
        [0] no values
        [one] { $values } value
       *[other] { $values } values
    } on the certificate by more than U (the larger of the two){ $verdicts ->
        [0] {""}
        [one] {" "}and changes { $verdicts } verdict
       *[other] {" "}and changes { $verdicts } verdicts
    }, above all { $element }: { $before } → { $after } ({ $times } U).

# The page.
report-title = Model and recording: { $recording }
report-shares =
    .caption = Left: share of the mismatch above noise removed by each finding, and the share that none explains. Right: χ² per degree of freedom of each channel's residual relative to the noise of unit and reference (noise alone: 1).
report-where = Where
    .caption = Colour: number of standard deviations by which the misfit of the standard's model exceeds noise, at the averaging time where it is most visible. The strip at the top marks rests, rates and turns; bars below a channel mark the segments in which a finding is located, with its share on the right.
    .caption-noise = Colour: number of standard deviations by which the misfit of the standard's model exceeds white noise, at the averaging time where it is most visible. Isolated pale cells are the unit's own slow noise; overall there is no more than chance allows.
report-what-was-left-out = Missing physics
report-before-after = Before and after
    .caption = Left: means of the residual over time; pale bars show its variation within a cell. Right: spectrum of the residual divided by the noise of one sample.
report-left-over = Residual
    .caption = Left: means of the residual over time. Right: spectrum of the residual divided by the noise of one sample; a rise at low frequencies is the unit's own flicker noise and drift.
report-held-out = Segments withheld from the fit: χ² per degree of freedom { $before } before, { $after } after (1: the noise of the residual at high frequencies).
report-rms-ratio = rms residual, after / before
report-certificate = Effect on the certificate
report-nothing-moved = No value on the certificate was found to change.
report-remarks = Remarks
report-method = Method and false alarms
    .compared = The readings are compared with models (1) and (2) of JJF 2003-2022, driven by the motion reported by the table and the gravity stated in the recording: no Earth rotation, no lever arm, a true vertical, no temperature dependence, no delay. Each effect of the catalogue is added in turn and all parameters are re-estimated together; an added effect must predict segments withheld from its fit.
report-origin = Origin
    .recording = recording
    .digest = SHA-256 digest of its content
    .model = compared with
    .unit = unit
    .station = station
    .code = created with
    .data = data file

# Heads of the cards and tables.
report-card-size = Size
report-card-refused = Why it has no name
report-card-equation = Equation
report-card-why = Evidence
report-card-tests = Further tests
report-card-alternatives = Alternatives
report-card-record = Confirming recording
report-card-certificate = Effect on the certificate
report-card-next = Next step
report-together = all
report-column-number = No.
report-column-parameter = parameter
report-column-value = value
report-column-uncertainty = U (k = 2)
report-column-unit = unit
report-column-channel = channel
report-column-share = share
report-column-where = where
report-column-along = along
report-column-segments = segments
report-column-element = certificate value
report-column-before = without
report-column-after = with
report-column-expanded = U
report-column-change = change / larger U
report-change = { $before } → { $after }
report-column-verdict = verdict
report-dimension-rate = rate
report-dimension-attitude = attitude
report-dimension-rotation_phase = table angle
report-dimension-frequency = frequency
report-dimension-temperature = temperature
report-dimension-time = time
report-dimension-after_moves = after moves
report-dimension-ramps = ramps
report-dimension-recorded = a recorded quantity
report-dimension-level = constant throughout

# The words in its pictures.
chart-time = time / { $unit }
chart-frequency = frequency / Hz
chart-none = none
chart-not-known = not known
chart-excess = excess over noise
chart-where = Where the standard's model misfits the recording
    .title = Excess of six channels over the time of the run
chart-segments =
    .static = rests
    .rate = rate
    .rotation = turn
chart-kinds =
    .static = static
    .rate = rate
    .rotation = rotation
chart-shares = Share of the mismatch above noise
    .title = Share of each finding and what is left
chart-not-explained = Not explained
chart-left-over = Left over: χ² per degree of freedom
chart-noise-alone = noise alone: 1
chart-residual = What is left over: reading − model
    .title = Residuals before and after
chart-spectrum = Its spectrum, white noise = 1
chart-lines =
    .model = the standard's model
    .before = before: the standard's model
    .after = after: with the findings
    .noise = noise of a mean, ±2σ
