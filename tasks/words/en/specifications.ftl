## What several specifications say: Earth's rotation in the data, missing items, uncertainties.

specifications-no-gravity = the local gravity is not stated
specifications-rates-needed = { $count ->
        [0] no constant rate
        [one] only one constant rate
       *[other] { $count } constant rates
    } about { $axis }; two are required
specifications-number-of-rates = { $axis } axis: { $count ->
        [one] 1 rate
       *[other] { $count } rates
    } ({ $rates } deg/s); { $clause } requires { $fewest } to { $most }.
specifications-one-direction = { $axis } axis: all rates have the same sign; the other direction is missing.
specifications-of-axis = { $axis }: { $reason }

specifications-mounting-unknown = The results are ordered for the axes of the mounting plane, but the uncertainties do not include how far the base of the unit may be tilted in the fixture (limit mounting, which the laboratory has to state).
specifications-unstated = No U is given where nobody states the largest error of what an element hangs on; u_A is the repeatability alone: { $items }. State how well the table holds a commanded rate (table_time.commanded_rate in the manifest, --commanded-rate of import, or the limit rate of the laboratory), and the limits of its angles.
    .item = { $item } { $elements } (u_A ≤ { $u } { $unit })
specifications-drift-in-run = The zeros drifted during the run, by a smooth course from end to end of { $channels } ({ $unit }): a value is a mean over this switch-on, and its budget has what the course adds to the mean over the run.
specifications-temperature = The elements hold at a temperature of the unit, by its own sensor, of { $at } °C.
specifications-temperatures = Temperature of the unit at which each element holds, by its own sensor, °C: { $items }.
    .item = { $item } { $at }
specifications-equipment-unknown = The recording names no specification, and the laboratory does not state the limits of its table: unknown errors of table and fixture are not included in the uncertainties, which cover the scatter of the data, the unit's resolution, gravity and latitude.

earth-rotation-unknown = The rests do not show whether the data contain Earth's rotation
earth-rotation-level-present = Earth's rotation is visible in the rests at different headings
earth-rotation-level-not-visible = Earth's rotation is not visible above the noise
earth-rotation-level-not-shown = The data do not show Earth's rotation: they are simulated or already compensated, or latitude or heading are wrong
earth-rotation-level-odd = The data show neither the full Earth rotation nor its absence: check latitude and heading
earth-rotation-vertical-present = The difference between rests facing up and down shows Earth's rotation, provided the unit's own g-sensitivity is small in comparison
earth-rotation-vertical-not-visible = Earth's rotation cannot be distinguished from noise and the unit's own g-sensitivity (up minus down)
earth-rotation-vertical-not-shown = The data do not show Earth's rotation (up minus down), unless a g-sensitivity of opposite sign masks it
earth-rotation-scale-factor-assumed = Where this run gives no gyro scale factor, a value of 1 was used to remove Earth's rotation.
specifications-stand-labelled = No encoders were recorded: for the uncertainties, the positions of the table's axes in each segment were taken from the labels.
specifications-stand-unknown = Neither encoders nor a description of the table's axes were recorded: the uncertainties take the tilts of each face and each setting as independent.
