## Where a finding's excess sits.

locate-absorbed = fully absorbed by the standard's model where the motion is known
locate-slight = less than 5 % of it in each
locate-uniform = evenly distributed
locate-intermittent = { $share } of it within a fifth of the time, in short intervals
locate-settling = { $where }; it decays with a time constant of { $seconds } s
locate-concentrated = { $share } of it { $where }, { $time } of the time
locate-variation = { $share } of it follows { $variable }: { $least } { $low }, { $most } { $high }
locate-or = { $first } or { $second }

locate-step = { $share } of it is a step of { $step } at { $time } s
locate-after = { $share } of it after { $time } s
locate-before = { $share } of it before { $time } s
locate-frequency = { $share } of it at { $frequency } Hz
locate-harmonics = { $share } of it has { $waves } per revolution of the { $axis } axis
locate-one-wave = one cycle
locate-waves-1 = { $first } cycles
locate-waves-2 = { $first } and { $second } cycles
locate-waves-3 = { $first }, { $second } and { $third } cycles

locate-rate = the rate
locate-rate-about = the rate about { $axis }
locate-rates = rates
locate-rates-about = rates about { $axis }
locate-at-rate = at { $rate } °/s
locate-at-rest = at rest
locate-rates-one = at { $rates } of { $low } °/s
locate-rates-above = at { $rates } of { $low } °/s and above
locate-rates-below = at { $rates } of { $high } °/s and below
locate-rates-between = at { $rates } from { $low } to { $high } °/s

locate-attitude = which axis points up
locate-up = with { $axis } up
locate-while-up = while { $cells } points up
locate-north = north
    .heading = which axis points up and which north
locate-table-y = the table's y axis
    .heading = which axis points up and which along the table's y axis
locate-up-and-to = with { $up } up and { $level } to { $towards }
locate-gravity-changes = whether the direction of gravity changes
locate-gravity-fixed = while the direction of gravity is constant
locate-gravity-changing = while the direction of gravity changes
locate-since-move = the time since the last move
locate-after-moves-within = within { $high } s after moves
locate-after-moves-between = { $low } s to { $high } s after moves
locate-after-moves-later = more than { $low } s after moves
locate-rate-changes = whether the rate changes
locate-rate-steady = at constant rate
locate-rate-changing = while the rate changes

locate-time = the time
locate-unit-temperature = the unit's temperature
locate-air-temperature = the air temperature
locate-air-humidity = humidity
locate-air-supply_voltage = supply voltage
locate-air-pressure = air pressure
locate-at-value = at { $value }
locate-values-between = from { $low } to { $high }
