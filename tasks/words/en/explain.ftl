## Where model and recording differ: what is compared, what a residual follows, what it does to the items.

# What a recording is compared with.
explain-model-fitted = the standard's model, its parameters fitted to this recording
explain-model-calibration = the standard's model with the given calibration
explain-model-simulation = the given simulation
explain-simulation-of-other-unit = the simulation names the unit { $its }, the recording { $own }

# What an effect outside the catalogue follows.
explain-other-parameters = different values of the standard's own parameters
explain-jumps = jumps between levels at several times
behaviour-motion = a motion that differs from the reported one
behaviour-input = an input that differs from the reported one
behaviour-sensor = an error that depends on the input
behaviour-signal = an error that depends on the signal's time history
behaviour-event = samples that deviate from their neighbours
explain-remainder = a remainder that follows none of the patterns searched for ({ $share } of the mismatch above noise, mostly from { $low } to { $high } Hz)
explain-slow-drift = a slow drift unrelated to any recorded quantity
explain-unlisted-heating = a heat that turning makes and no thermometer sees, through more than one lag
explain-unlisted-hysteresis = hysteresis in a form that no publication lists
explain-unlisted-non-linearity = a non-linearity in a form that no publication lists
explain-unlisted-rectification = vibration rectification in a form that no publication lists
explain-unlisted-late-temperature = a temperature effect that comes late, in a form that no publication lists
explain-unlisted-attitude = an error that follows the attitude in a form of its own
explain-unlisted-other-rates = an error that follows the rates about the other axes in a form of its own
explain-unlisted-angular-acceleration = an error that follows the angular acceleration in a form that no publication lists
explain-unlisted-fixture = a fixture that gives way to attitude or speed in a form that no publication lists
explain-unlisted-supply = an error that follows the supply voltage in a form that no publication lists
explain-scale-factor-drift = a scale factor that wanders with time, unrelated to any recorded quantity
explain-wave = an oscillation with a period of about { $period } s
explain-relaxation = a relaxation after { $event } with a time constant of about { $tau } s
explain-event-reposition = each change of position
explain-event-gravity-turn = each change of gravity's direction
explain-event-stop = each stop
explain-follows = an error that follows { $signal }
explain-lag = an error that follows { $signal } with a lag of about { $tau } s
explain-signal-own-rate = the rate about its own axis
explain-signal-squared-rate = the square of the rate
explain-signal-rate-size = the magnitude of the rate
explain-signal-own-force = the specific force along its own axis
explain-signal-own-force-size = the magnitude of the specific force along its own axis
explain-product-other-rates = an error that follows the product of the rates about the other two axes
explain-product-own-rate = an error that follows products of its own rate with the others
explain-product-other-forces = an error that follows the product of the specific forces along the other two axes
explain-product-own-force = an error that follows products of its own specific force with the others
explain-product-squared-other-forces = an error that follows the squares of the other specific forces
explain-product-squared-other-rates = an error that follows the squares of the rates
explain-product-squared-own-rate = an error that follows the square of its own rate
explain-product-rates = an error that follows the rates
explain-product-other-rate-sizes = an error that follows the magnitudes of the other rates
explain-product-fourth-power = an error that follows the fourth power of the rate
explain-product-angular-acceleration = an error that follows the angular acceleration
explain-product-angular-acceleration-size = an error that follows the magnitude of the angular acceleration
explain-recorded-humidity = the relative humidity
explain-recorded-pressure = the air pressure
explain-recorded-air-temperature = the air temperature
explain-recorded-times-input = { $signal } times the input
explain-harmonic = an error that follows the angle of table axis { $axis }, { $order } times per revolution
explain-lean = a tilt of the unit near { $angle }° of table axis { $axis }
explain-tip = a tilt of the unit of one size to either side, as the specific force points along ({ $side }) or against it
explain-lost-motion = a unit that lags behind the encoder of table axis { $axis } by one angle, in whichever direction it last turned

# Where the search ends early.

# What the findings do to the calibration items.
explain-items-by-angles = The items of JJF 1536 are computed from accumulated angles, not from the rates analysed here: consequences for them were not estimated.
explain-stated-together = { $titles } partly compensate each other in this recording: their consequences for the items are stated jointly, because each alone would change values that the others change back.
explain-items-not-estimated = The consequences of the findings for the items were not estimated: { $reason }

# A calibration of readings that were corrected for findings.
explain-adopted = Before the clauses were applied, the readings were corrected for effects that the specification's models omit: { $terms }. The specification does not provide for this.
explain-adopted-term = { $title } ({ $name })
explain-adopted-term-parameters = { $title } ({ $name }: { $parameters })
explain-adopted-information = The quantities given for information are those of the readings as recorded, before the correction.
explain-adopted-alike = This recording does not distinguish { $term } from { $others }; the correction was made for the former.
explain-adopted-not-shown = The recording does not show { $term } above its noise (ΔBIC { $bic }); it was corrected for nevertheless, as ordered.
explain-adopted-undetermined = The recording does not determine { $parameters } of { $term } to better than its own size: it was fixed at zero while the rest was fitted, and no correction was made for it; U includes its possible size.
explain-adopted-motion-unknown = The motion is not known in all rows; where it is unknown no correction was made: { $segments }.
explain-not-adopted-random = { $term } was not corrected for: it is random and has no parameter, so that U could not express how well it is known; it remains in the readings as noise.
explain-budget-line = { $title }, { $parameter }
