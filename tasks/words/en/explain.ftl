## Where model and recording differ: what is compared, what a residual follows, what it does to the items.

# What a recording is compared with.
explain-model-fitted = the standard's model, its parameters fitted to this recording
explain-model-calibration = the standard's model with the given calibration
explain-model-simulation = the simulation that was given

# What an effect outside the catalogue follows.
explain-other-parameters = other values of the standard's own parameters
explain-jumps = jumps between levels at several times
behaviour-motion = a motion that differs from the reported one
behaviour-input = an input that differs from the reported one
behaviour-sensor = a change that follows the input
behaviour-signal = a change that follows the course of the signal
behaviour-event = samples that differ from their neighbours
explain-remainder = what is left over and follows no pattern that was looked for ({ $share } of the mismatch above noise, mostly from { $low } to { $high } Hz)
explain-slow-drift = a slow drift that nothing recorded follows
explain-wave = a wave with a period of about { $period } s
explain-relaxation = a relaxation after { $event }, e-folding in about { $tau } s
explain-event-reposition = each move to another position
explain-event-gravity-turn = each turn of gravity's direction
explain-event-stop = each stop
explain-follows = readings that follow { $signal }
explain-lag = readings that follow { $signal }, lagging by about { $tau } s
explain-signal-own-rate = the rate about its own axis
explain-signal-squared-rate = the square of the rate
explain-signal-rate-size = the size of the rate
explain-signal-own-force = the specific force along its own axis
explain-signal-own-force-size = the size of the specific force along its own axis
explain-product-other-rates = readings that follow the product of the rates about the two other axes
explain-product-own-rate = readings that follow products of its own rate with the others
explain-product-other-forces = readings that follow the product of the specific forces on the two other axes
explain-product-own-force = readings that follow products of its own specific force with the others
explain-product-squared-other-forces = readings that follow the squares of the other specific forces
explain-product-squared-other-rates = readings that follow the squares of the rates
explain-product-squared-own-rate = readings that follow the square of its own rate
explain-product-rates = readings that follow the rates
explain-product-other-rate-sizes = readings that follow the sizes of the other rates
explain-product-fourth-power = readings that follow the fourth power of the rate
explain-product-angular-acceleration = readings that follow the angular acceleration
explain-product-angular-acceleration-size = readings that follow the size of the angular acceleration
explain-recorded-humidity = the humidity
explain-recorded-pressure = the air pressure
explain-recorded-air-temperature = the air temperature
explain-recorded-times-input = { $signal } times the input
explain-harmonic = readings that follow the angle of table axis { $axis }, { $order } times a turn
explain-lean = a lean of the unit near { $angle }° of table axis { $axis }

# Where the search ends early.
explain-search-stopped = The search stopped at its budget of { $seconds } s of processor time: what is left was not searched again about the values that were fitted, and effects beside those found were not tried.

# What the findings do to the calibration items.
explain-items-by-angles = The items of JJF 1536 come from the accumulated angles, not from the rates that were explained: no consequence was estimated.
explain-stated-together = { $titles } make up for each other in part in this recording: what they do to the items is stated for them together, since each by itself would move values that the others move back.
explain-items-not-estimated = What the findings do to the items was not estimated: { $reason }

# A calibration of readings that were corrected for findings.
explain-adopted = Before the clauses were followed, the readings had taken off what the specification's models leave out: { $terms }. The specification does not provide for it.
explain-adopted-term = { $title } ({ $name })
explain-adopted-term-parameters = { $title } ({ $name }: { $parameters })
explain-adopted-not-shown = The recording does not show { $term } above its noise (ΔBIC { $bic }); it was taken off all the same, as ordered.
explain-adopted-undetermined = The recording does not determine { $parameters } of { $term } better than its size: it was held at nothing while all else was fitted, and nothing was taken off for it; U holds what it may be.
explain-adopted-motion-unknown = The motion is not known in all rows, and nothing was taken off where it is not: { $segments }.
explain-not-adopted-random = { $term } was not taken off: its course is random and has no parameter, so that U could not say how well it is known; it stays in the readings, as noise.
explain-budget-line = { $title }, { $parameter }
