## The clauses of JJF 1536-2015: what is missing, what was not as the clause asks.

jjf1536-slow-sampling = { $count } segments were sampled at { $rate } Hz; 7.2.1 and 7.3.1 ask for { $asked } Hz or more.

jjf1536-rate-not-read = { $segment }: turned at { $rate } deg/s about { $axis } by label, mount and table, but { $axis } reads { $reading } deg/s: it was left out; state which axis was turned.
jjf1536-no-rest-before = { $axis } axis: no rest before the rate points, of which eq. (11) takes the mean; the scale factor does not depend on it, its fit offset does.
jjf1536-no-rest-after = { $axis } axis: no rest after the rate points, of which eq. (11) takes the mean; the scale factor does not depend on it, its fit offset does.
jjf1536-no-rest-before-or-after = { $axis } axis: no rest before or after the rate points, of which eq. (11) takes the mean; the scale factor does not depend on it, its fit offset does.
jjf1536-line-scatter = { $axis } axis: the rate points scatter about the line of eq. (13) { $factor } times more than the noise explains; the uncertainty was enlarged by as much.

jjf1536-no-position = no rest that serves the zero offset
jjf1536-few-positions = { $count } positions, four are needed, and where the axis pointed is not recorded
jjf1536-earth-remains = { $count ->
        [1] 1 position leaves
       *[other] { $count } positions leave
    } up to { $percent } % of Earth's rotation; eq. (16) needs positions at equal angles, each axis as often one way as the other
jjf1536-attitude-contradicted = { $axis } axis: the labels of { $segments } point the axes otherwise than table and mount do: table and mount were used.
jjf1536-attitude-not-recorded = { $axis } axis: neither encoders nor labels show where it pointed; that its { $count } positions cancel Earth's rotation was not checked.
jjf1536-number-of-positions = { $axis } axis: { $count } positions; 7.2.1 asks for four, 7.2.2 recommends twelve.
jjf1536-short-position = { $axis } axis: positions held for { $minutes } min; 7.2 has { $asked } min, or what the unit's working time makes of it.
jjf1536-positions-scatter = { $axis } axis: the positions differ { $factor } times more than Earth's rotation and the noise explain; the uncertainty was enlarged by as much.

jjf1536-no-turns = { $axis }: no turns about { $axis }
jjf1536-no-back = { $axis }: no backward turns about { $axis }; eq. (17) takes the difference of both directions
jjf1536-no-forward = { $axis }: no forward turns about { $axis }; eq. (17) takes the difference of both directions
jjf1536-turn-not-read = { $axis }: in turns about { $axis } its own angle says otherwise; check the labels and the mount
jjf1536-turns-as-agreed = { $axis } axis: { $count } turns at { $rate } deg/s; 7.3.1 has { $turns_asked } turns at a high rate, { $rate_asked } deg/s for example, where no agreement says otherwise.
jjf1536-turn-times-differ = { $axis } axis: turning forward and back took times that differ by { $seconds } s; where the zero offset is not known it does not cancel.
jjf1536-turned-angle-contradicted = { $segment }: labelled { $label } deg about { $axis }, but the table shows { $table } deg: the table's angle was used.
jjf1536-not-whole-turns = { $segment }: turned by { $angle } deg, not by whole turns as 7.3.1 asks; Earth's rotation does not cancel.

## Sections of the certificate's results.

section-ahrs-scale-factors = Scale factors
section-ahrs-zero-offsets = Zero offsets
section-ahrs-misalignment = Misalignment angles
