## What explain answers: the verdict, its findings, and the page of the report.

# Joints. The last full stop of a sentence stands in the sentence itself.
report-sentence = { $text }.
report-sentences = { $first } { $rest }
report-or = { $first } or { $rest }

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
report-place = { $channel } ({ $share }): { $description }
report-places = It sits in { $places }.
report-predicted = Stretches that the fit did not see become { $times } as probable ({ $nats } nats)
report-not-predicted = Stretches that the fit did not see are not predicted better ({ $nats } nats)
report-times = { $number } times
report-more-than-times = more than { $number } times
report-why = { $prediction }; ΔBIC = { $bic }: { $evidence }, with its parameters paid for.
report-evidence-very-strong = very strong evidence
report-evidence-strong = strong evidence
report-evidence-some = some evidence
report-evidence-none = no evidence by this measure
report-alternatives = This recording cannot tell it from { $effects }.
report-no-alternatives = No other effect of the catalogue fits this recording as well.
report-to-record = To be sure, record: { $recording }.
report-moves-most = Of the certificate it moves most: { $element }, from { $before } with it left out to { $after } with it taken into account (k = 2), { $times } U.
report-verdict-changes = The verdict on { $item } changes from { $before } to { $after }.

# The verdict.
report-no_mismatch = no mismatch
    .headline = No mismatch: the standard's model accounts for this recording
report-explained = explained
    .headline = Explained: what the standard's model leaves out is found
report-partly_explained = partly explained
    .headline = Partly explained: something is found, something stays without a name
report-unexplained = unexplained
    .headline = Unexplained: model and recording differ, and nothing in the catalogue accounts for it
report-nothing-found = Nothing was found that the standard's model leaves out. On stretches that the fit did not see it leaves χ² = { $chi2 } per degree of freedom (noise alone: 1). What is smaller than the noise lets see, or what the standard's parameters absorb whole, this recording cannot show.
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
       *[other] ; what it follows: { $follows }
    }.
report-gained = On stretches that the fit did not see, χ² per degree of freedom goes from { $before } to { $after } (noise alone: 1).
report-gained-most = On stretches that the fit did not see, χ² per degree of freedom goes from { $before } to { $after } (noise alone: 1), and the rms residual of the { $channel } falls to { $share }.
report-values-moved = Taking it into account moves { $values ->
        [0] no values
        [one] { $values } value
       *[other] { $values } values
    } of the certificate by more than U.
report-values-and-verdicts-moved = Taking it into account moves { $values ->
        [0] no values
        [one] { $values } value
       *[other] { $values } values
    } of the certificate by more than U and changes { $verdicts ->
        [one] { $verdicts } verdict
       *[other] { $verdicts } verdicts
    }.

# The page.
report-title = Model and recording: { $recording }
report-where = Where
    .caption = Colour: by how many standard deviations the misfit of the standard's model stands above noise, at the averaging time at which it shows most. The strip above tells rests, rates and turns; bars below a channel tell in which segments a finding sits, the numbers at the right its share.
    .caption-noise = Colour: by how many standard deviations the misfit of the standard's model stands above white noise, at the averaging time at which it shows most. Single pale cells are the unit's own slow noise: all in all there is no more than chance allows.
report-what-was-left-out = What was left out
report-before-after = Before and after
    .caption = Left: means of the residual over time; pale bars show what swings within a cell. Right: spectrum of the residual divided by the noise of a sample.
report-left-over = What is left over
    .caption = Left: means of the residual over time. Right: spectrum of the residual divided by the noise of a sample; a rise at low frequencies is the flicker and drift of the unit's own noise.
report-held-out = Stretches that the fit did not see: χ² per degree of freedom { $before } before, { $after } after (noise alone: 1).
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
report-card-follows = What it follows
report-card-equation = Equation
report-card-why = Why we believe it
report-card-alternatives = Could also be
report-card-record = To be sure, record
report-card-certificate = On the certificate
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
