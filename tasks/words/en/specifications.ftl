## What several specifications say: Earth's rotation in the data, missing items, uncertainties.

specifications-no-gravity = the local gravity is not stated
specifications-rates-needed = { $axis }: { $count } rates about { $axis }; two are required
specifications-number-of-rates = { $axis } axis: { $count } rates ({ $rates } deg/s); { $clause } requires { $fewest } to { $most }.
specifications-one-direction = { $axis } axis: all rates have the same sign; the other direction is missing.
specifications-of-axis = { $axis }: { $reason }

specifications-mounting-unknown = The results are ordered for the axes of the mounting plane, but the uncertainties do not include how far the base of the unit may be tilted in the fixture (limit mounting, which the laboratory has to state).
specifications-equipment-unknown = The recording names no specification, and the laboratory does not state the limits of its table: unknown errors of table and fixture are not included in the uncertainties, which cover the scatter of the data, the unit's resolution, gravity and latitude.

earth-rotation-unknown = The rests do not show whether the data contain Earth's rotation
earth-rotation-level-present = Earth's rotation is visible in the rests at different headings ({ $gain }; 1: in full, 0: absent)
earth-rotation-level-not-visible = Earth's rotation is not visible above the noise ({ $gain }; 1: in full, 0: absent)
earth-rotation-level-not-shown = The data do not show Earth's rotation ({ $gain }; 1: in full, 0: absent): they are simulated or already compensated, or latitude or heading are wrong
earth-rotation-level-odd = The data show neither the full Earth rotation nor its absence ({ $gain }; 1: in full, 0: absent): check latitude and heading
earth-rotation-vertical-present = The difference between rests facing up and down shows Earth's rotation ({ $gain }; 1: in full, 0: absent), provided the unit's own g-sensitivity is small in comparison
earth-rotation-vertical-not-visible = Earth's rotation cannot be distinguished from noise and the unit's own g-sensitivity (up minus down, { $gain }; 1: in full, 0: absent)
earth-rotation-vertical-not-shown = The data do not show Earth's rotation (up minus down, { $gain }; 1: in full, 0: absent), unless a g-sensitivity of opposite sign masks it
earth-rotation-scale-factor-assumed = Where this run gives no gyro scale factor, a value of 1 was used to remove Earth's rotation.
specifications-stand-labelled = No encoders were recorded: how the table's axes stood in each segment was taken from the labels, for the uncertainties.
specifications-stand-unknown = Neither encoders nor a description of the table's axes were recorded: in the uncertainties each face and each setting is tilted for itself.
