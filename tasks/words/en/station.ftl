## What was noticed during a run. $place is one of the three messages at the end.

station-unit-lost-samples = The unit's counter shows { $total } lost samples ({ $place }).
station-unit-bad-frames = { $total } frames of the unit had a wrong check sum and were left out ({ $place }).
station-encoder-gap = { $total } captured encoder samples are missing ({ $place }).
station-air-temperature = The air was at { $low } to { $high } °C where the procedure allows { $limits } °C ({ $place }).
station-air-humidity = The air was at { $low } to { $high } %RH where the procedure allows { $limits } %RH ({ $place }).
station-table-unsettled = Axis { $subject } of the table was not settled while data were taken ({ $place }).
station-table-rate = The encoders show axis { $subject } turning { $low } % to { $high } % off the rate asked ({ $place }).
station-stuck-channel = Channel { $subject } of the unit did not change by one count ({ $place }).
station-spikes = Channel { $subject } of the unit has { $total } spikes ({ $place }).
station-segment-repeated = Segment { $subject } was measured again, for its data were not sound.

station-place =
    { $count ->
        [0] between the measured segments
       *[other] { $more ->
            [0] in { $names }
            [one] in { $names } and { $more } more segment
           *[other] in { $names } and { $more } more segments
        }
    }

## The equipment of the virtual station.

station-virtual-turntable = { $axes }-axis position and rate turntable (virtual)
station-virtual-fixture = Calibration fixture (virtual)
station-virtual-chamber = Temperature chamber (virtual)

## What a trial of a device found.

station-check-found = It is the one described.
station-check-homed = Ready to move.
station-check-captured = A sample every { $every } ms, captured by the table.
station-check-polled = A sample every { $every } ms, polled, its time within ±{ $half_width } ms.
station-check-moved = Turned by { $angle }° and back, within { $within }″.
station-check-unit = { $rate } Hz, frames with a wrong check sum: { $bad }; mean { $means }.
station-check-state =
    { $axes }{ $count ->
        [0] .
       *[other] ; reports { $trips }.
    }
station-check-climate = { $values }.

## The log of a run: how it came into each state; $now is the segment or the step.

station-log-begun = The run begins: { $now }.
station-log-warming-up = Warm-up, as the procedure asks.
station-log-measuring = { $now }, segment { $number } of { $count }: next in the procedure.
station-log-repeating = { $now } again, for its data were not sound.
station-log-paused = The operator has the run rest (Ctrl-Z).
station-log-turning-over = The unit is turned over in its fixture: { $now }.
station-log-finishing = Every segment is measured, and the last data are waited for.
station-log-done = The run is complete.
station-log-stopped = The run stopped: { $cause }
station-log-given-up = The unit was given up, and the run went on without it: { $cause }
station-log-operator = The operator stopped the run.
station-log-alarm = Noticed: { $alarm }.
station-log-times = { $alarm } ({ $count }×)

station-alarm-unit-lost-samples = samples of the unit lost
station-alarm-unit-bad-frames = frames of the unit with a wrong check sum
station-alarm-encoder-gap = encoder samples of the table lost
station-alarm-air-temperature = air temperature outside the procedure's limits
station-alarm-air-humidity = air humidity outside the procedure's limits
station-alarm-table-unsettled = axis { $subject } of the table not settled while data were taken
station-alarm-table-rate = rate of axis { $subject } by the encoders other than asked
station-alarm-stuck-channel = channel { $subject } of the unit stuck
station-alarm-spikes = spikes in channel { $subject } of the unit
