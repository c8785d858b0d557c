## What was noticed during a run. $place is one of the three messages at the end.

station-unit-lost-samples = The unit's counter shows { $total } lost samples ({ $place }).
station-unit-bad-frames = { $total } frames of the unit had a wrong checksum and were discarded ({ $place }).
station-encoder-gap = { $total } captured encoder samples are missing ({ $place }).
station-air-temperature = The air temperature was { $low } to { $high } °C; the procedure allows { $limits } °C ({ $place }).
station-air-humidity = The relative humidity was { $low } to { $high } %RH; the procedure allows { $limits } %RH ({ $place }).
station-table-unsettled = Table axis { $subject } had not settled while data were taken ({ $place }).
station-table-rate = According to the encoders the rate of axis { $subject } deviates by { $low } % to { $high } % from the commanded rate ({ $place }).
station-stuck-channel = Channel { $subject } of the unit did not change by a single count ({ $place }).
station-spikes = Channel { $subject } of the unit has { $total } spikes ({ $place }).
station-segment-repeated = Segment { $subject } was measured again because its data were faulty.

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

station-check-found = The device is the one described.
station-check-homed = Ready to move.
station-check-captured = One sample every { $every } ms, captured by the table.
station-check-polled = One sample every { $every } ms, polled, timed to within ±{ $half_width } ms.
station-check-moved = Turned by { $angle }° and back, within { $within }″.
station-check-unit = { $rate } Hz, frames with a wrong checksum: { $bad }; mean { $means }.
station-check-serial = The unit says that it is { $serial }; the station file names { $named }.
station-check-state =
    { $axes }{ $count ->
        [0] .
       *[other] ; reports { $trips }.
    }
station-check-climate = { $values }.

## The log of a run: how it came into each state; $now is the segment or the step.

station-log-begun = Run started: { $now }.
station-log-warming-up = Warm-up, as the procedure requires.
station-log-measuring = { $now }, segment { $number } of { $count }.
station-log-repeating = { $now } repeated because its data were faulty.
station-log-paused = Paused by the operator (Ctrl-Z).
station-log-turning-over = Unit being turned over in its fixture: { $now }.
station-log-finishing = All segments measured; waiting for the last data.
station-log-done = Run complete.
station-log-stopped = Run stopped: { $cause }
station-log-given-up = The unit was abandoned and the run continued without it: { $cause }
station-log-operator = Run stopped by the operator.
station-log-stopped-by = Run stopped by { $name }.
station-log-alarm = Alarm: { $alarm }.
station-log-times = { $alarm } ({ $count }×)

station-alarm-unit-lost-samples = lost samples from the unit
station-alarm-unit-bad-frames = frames from the unit with a wrong checksum
station-alarm-encoder-gap = lost encoder samples from the table
station-alarm-air-temperature = air temperature outside the procedure's limits
station-alarm-air-humidity = relative humidity outside the procedure's limits
station-alarm-table-unsettled = table axis { $subject } not settled while data were taken
station-alarm-table-rate = encoder rate of axis { $subject } differs from the commanded rate
station-alarm-stuck-channel = channel { $subject } of the unit stuck
station-alarm-spikes = spikes in channel { $subject } of the unit
station-page-stop = STOP
station-page-lockout = Orders wait since the stop by { $by }.
station-page-release = Release: it may turn
station-page-left = remaining
station-page-none = no run yet
station-page-at-rest = The table is at rest, { $seconds } s after the stop.
station-page-not-confirmed = NOT CONFIRMED to be at rest: use the emergency stop.

## What the person at the station does about an alarm, by its kind.

station-todo =
    .unit-lost-samples = Check the unit's cable and connectors; if samples keep being lost, lower its output rate or use another interface.
    .unit-bad-frames = Check the unit's cable, its shield and ground, and the baud rate in the station file.
    .encoder-gap = Check the network cable of the table's controller, and that no other program reads from it.
    .air-temperature = Close the chamber, check its set temperature and wait until the air is within the limits.
    .air-humidity = Check the room's air conditioning or the chamber's drier and wait until the humidity is within the limits.
    .table-unsettled = Check that the load is balanced and clamped; if it recurs, have the table's servo tuned.
    .table-rate = Do not use this run; have the table's rate checked before the next unit is measured.
    .stuck-channel = Restart the unit; if the channel stays stuck, the unit is faulty: reject it.
    .spikes = Check the unit's connector, supply and clamping; if spikes stay, the unit is faulty: reject it.
    .given-up = Take this unit out and check its cable and supply; the others go on. Order it again afterwards.
station-of-unit = { $unit }: { $alarm }

## Why a run or an order stopped, failed or cannot begin, as the pages show it.

station-cause =
    .and = { $first } { $rest }
    .other = The log says why.
    .other-unit = Unit { $found } is mounted, and the order is for { $ordered }: mount { $ordered }, or order { $found }.
    .no-serial = Unit { $unit } does not tell its serial number: check its supply and its cable.
    .busy = Another run is going on at station { $station }.
    .disk = The disk for recordings has { $free } GiB free, and a run may need { $needed } GiB: free some space.
    .catalogue = The database of the catalogue cannot be used just now.
    .locked-out = { $name } stopped station { $station }: release it on the page Line once it may turn.
    .no-worker = The Prefect worker of the run was lost.
    .cancelled = The run was cancelled in Prefect.
    .not-written = The recording could not be written ({ $why }).
    .during = During “{ $now }”: { $cause }
    .given-up = Unit { $unit } was abandoned: { $cause }
    .invalid = The run is invalid: { $reason }
    .silent = The device at { $device } does not answer: check that it is switched on and connected.
    .nothing-sent = The unit at { $unit } has sent nothing for { $seconds } s: check its supply and its cable.
    .died = The process that carried it out ended without a word.
    .no-frame = The unit at { $unit } has sent bytes and no whole frame for { $seconds } s: check its frame in the station file, its baud rate and its cable.
    .fault = The table reports a fault: read it at the controller, clear it there and start again.
    .emergency-stop = The emergency stop of the table is pressed: make the table safe, release it, reset the table and start again.
    .interlock = The interlock of the table is open: close the guard, reset the table and start again.
    .watchdog = The table heard nothing for too long and stopped itself: check the network, reset the table and start again.
    .not-settled = Axis { $axis } of the table has not settled within { $seconds } s: check its load, its balance and its servo.
    .clock = The clock of the station stands or jumped back, as after a restart: restart the controller, then begin the run again.
    .line = The line of the unit at { $unit } broke or cannot be opened: check the unit and its cable.
    .unit-restarted = The time of the unit at { $unit } went back, as after a restart: check its supply, then begin again.
    .no-home = The table has not found its home: check whether an axis is blocked.
    .fixture = The fixture has not arrived at { $turn }: look whether it is blocked.
    .still-turns = The table still turns although it was commanded to stop.
    .no-server = Prefect’s server does not answer: see that it runs.

## What became of an order, for whoever operates the line.

order-outcome =
    .failed = Order { $number }, unit { $unit } on station { $station }, failed: { $cause } What to do: remove the cause, then repeat or leave the order on the page Do.
    .refused = Order { $number }, unit { $unit } on station { $station }, was refused: { $cause } What to do: correct it, then repeat the order on the page Do.
    .waits = Order { $number }, unit { $unit } on station { $station }, has not been able to begin for { $minutes } min: { $cause }
    .never-begun = Order { $number }, unit { $unit } on station { $station }, was never begun: { $cause }
    .nothing-takes-it = nothing takes the orders of this station. What to do: see that the station's computer runs and its worker with it.
