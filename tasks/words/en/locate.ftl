## Where a finding's excess sits.

locate-absorbed = where the motion is known, the standard's model takes it up whole
locate-slight = less than 5 % of it in each
locate-uniform = everywhere alike
locate-intermittent = { $share } of it in a fifth of the time, in short stretches
locate-settling = { $where }; it fades with { $seconds } s
locate-concentrated = { $share } of it { $where }, { $time } of the time
locate-variation = { $share } of it follows { $variable }: { $least } { $low }, { $most } { $high }
locate-or = { $first } or { $second }

locate-step = { $share } of it is a step of { $step } at { $time } s
locate-after = { $share } of it after { $time } s
locate-before = { $share } of it before { $time } s
locate-frequency = { $share } of it at { $frequency } Hz
locate-harmonics = { $share } of it is { $waves } per turn of the { $axis } axis
locate-one-wave = one wave
locate-waves-1 = { $first } waves
locate-waves-2 = { $first } and { $second } waves
locate-waves-3 = { $first }, { $second } and { $third } waves

locate-rate = the rate
locate-rate-about = the rate about { $axis }
locate-rates = rates
locate-rates-about = rates about { $axis }
locate-at-rate = at { $rate } °/s
locate-at-rest = at rest
locate-rates-one = at { $rates } of { $low } °/s
locate-rates-above = at { $rates } of { $low } °/s and more
locate-rates-below = at { $rates } of { $high } °/s and less
locate-rates-between = at { $rates } from { $low } to { $high } °/s

locate-attitude = which axis is up
locate-up = with { $axis } up
locate-while-up = while { $cells } is up
locate-north = north
    .heading = which axis is up and which to north
locate-table-y = the table's y
    .heading = which axis is up and which to the table's y
locate-up-and-to = with { $up } up and { $level } to { $towards }
locate-gravity-changes = whether gravity's direction changes
locate-gravity-fixed = while gravity's direction stays
locate-gravity-changing = while gravity's direction changes
locate-since-move = the time since the last move
locate-after-moves-within = within { $high } s after moves
locate-after-moves-between = { $low } s to { $high } s after moves
locate-after-moves-later = later than { $low } s after moves
locate-rate-changes = whether the rate changes
locate-rate-steady = at a steady rate
locate-rate-changing = while the rate changes

locate-time = the time
locate-unit-temperature = the unit's temperature
locate-air-temperature = the air's temperature
locate-air-humidity = humidity
locate-air-supply_voltage = supply voltage
locate-air-pressure = air pressure
locate-at-value = at { $value }
locate-values-between = from { $low } to { $high }
