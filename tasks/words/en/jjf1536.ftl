## The clauses of JJF 1536-2015: what is missing, what was not as the clause asks.

jjf1536-slow-sampling = { $count ->
        [one] 1 segment was
       *[other] { $count } segments were
    } sampled at { $rate } Hz; 7.2.1 and 7.3.1 require { $asked } Hz or more.

jjf1536-rate-not-read = { $segment }: rotated at { $rate } deg/s about { $axis } according to label, mount and table, but { $axis } reads { $reading } deg/s: the segment was excluded; state which axis was rotated.
jjf1536-no-rest-before = { $axis } axis: no rest before the rate points, of which eq. (11) takes the mean; this affects the fit offset but not the scale factor.
jjf1536-no-rest-after = { $axis } axis: no rest after the rate points, of which eq. (11) takes the mean; this affects the fit offset but not the scale factor.
jjf1536-no-rest-before-or-after = { $axis } axis: no rest before or after the rate points, of which eq. (11) takes the mean; this affects the fit offset but not the scale factor.
jjf1536-line-scatter = { $axis } axis: the rate points scatter about the line of eq. (13) { $factor } times more than the noise explains; the uncertainty was increased accordingly.

jjf1536-no-position = no rest suitable for the zero offset
jjf1536-few-positions = { $count ->
        [one] 1 position
       *[other] { $count } positions
    }; four are required, and the direction of the axis is not recorded
jjf1536-earth-remains = { $count ->
        [1] 1 position leaves
       *[other] { $count } positions leave
    } up to { $percent } % of Earth's rotation; eq. (16) needs positions at equal angles, each axis as often one way as the other
jjf1536-steady-rate-lost = The positions show { $gain } ± { $u } (k = 2) of Earth's rotation, which gyros read in full: the unit takes a steady rate off by itself, as an estimator of its own zero does (or was not turned between the positions). The zero offset is what is left of it, not that of the gyros, and has no U; have the estimator switched off.
jjf1536-attitude-contradicted = { $axis } axis: the labels of { $segments } contradict the attitude given by table and mount: table and mount were used.
jjf1536-attitude-not-recorded = { $axis } axis: neither encoders nor labels show its direction; it was not checked whether its { $count ->
        [one] one position cancels
       *[other] { $count } positions cancel
    } Earth's rotation.
jjf1536-number-of-positions = { $axis } axis: { $count ->
        [one] 1 position
       *[other] { $count } positions
    }; 7.2.1 requires four, 7.2.2 recommends twelve.
jjf1536-short-position = { $axis } axis: positions held for { $minutes } min; 7.2 specifies { $asked } min, or a time adapted to the unit's operating time.
jjf1536-positions-scatter = { $axis } axis: the positions differ { $factor } times more than Earth's rotation and the noise explain; the uncertainty was increased accordingly.

jjf1536-crooked = { $axis } axis: by its mount the unit was turned about its other axes too; what those read is only known where each of them was turned
jjf1536-no-turns = no turns about { $axis }
jjf1536-no-back = no backward turns about { $axis }; eq. (17) takes the difference of both directions
jjf1536-no-forward = no forward turns about { $axis }; eq. (17) takes the difference of both directions
jjf1536-turn-not-read = in turns about { $axis } the angle that { $axis } reads disagrees; check the labels and the mount
jjf1536-turns-as-agreed = { $axis } axis: { $count ->
        [one] 1 turn
       *[other] { $count } turns
    } at { $rate } deg/s; 7.3.1 specifies { $turns_asked } turns at a high rate, for example { $rate_asked } deg/s, unless agreed otherwise.
jjf1536-turn-times-differ = { $axis } axis: the durations of forward and backward rotation differ by { $seconds } s; what the zero offset and gravity add in that time does not cancel (a known zero offset is taken off).
jjf1536-turned-angle-contradicted = { $segment }: labelled { $label } deg about { $axis }, but the table shows { $table } deg: the table's angle was used.
jjf1536-turned-angle-wrong = { $axis } axis: in the turns it reads { $percent } % more than its scale factor makes of their angle: a part of the turns lies outside of what is labelled, the angle is another, or the scale factor has changed since. The misalignment about { $axis } has no U.
jjf1536-not-whole-turns = { $segment }: rotated by { $angle } deg, not by whole turns as 7.3.1 requires; Earth's rotation does not cancel.

## Sections of the certificate's results.

section-ahrs-scale-factors = Scale factors
section-ahrs-zero-offsets = Zero offsets
section-ahrs-misalignment = Misalignment angles
