## What several specifications say: Earth's rotation in the data, missing items, uncertainties.

specifications-no-gravity = the local gravity is not stated
specifications-rates-needed = { $axis }: { $count } rates about { $axis }, two are needed
specifications-number-of-rates = { $axis } axis: { $count } rates ({ $rates } deg/s); { $clause } asks for { $fewest } to { $most }.
specifications-one-direction = { $axis } axis: all rates have the same sign; the other direction is missing.
specifications-of-axis = { $axis }: { $reason }

specifications-equipment-unknown = The recording names no specification, and the laboratory does not state what its table may be off by: what is not known of table and fixture is not in the uncertainties, which hold the scatter of the data, the unit's resolution, gravity and latitude.

earth-rotation-unknown = The rests do not show whether Earth's rotation is in the data
earth-rotation-level-present = Earth's rotation is visible in the rests at different headings ({ $gain }; 1: in full, 0: absent)
earth-rotation-level-not-visible = Earth's rotation is not visible above the noise ({ $gain }; 1: in full, 0: absent)
earth-rotation-level-not-shown = The data do not show Earth's rotation ({ $gain }; 1: in full, 0: absent): they are simulated or compensated already, or latitude or heading are not as stated
earth-rotation-level-odd = The data show neither the whole of Earth's rotation nor its absence ({ $gain }; 1: in full, 0: absent): check latitude and heading
earth-rotation-vertical-present = Up minus down the rests read Earth's rotation ({ $gain }; 1: in full, 0: absent), if the unit's own g-sensitivity is small beside it
earth-rotation-vertical-not-visible = Earth's rotation cannot be distinguished from noise and the unit's own g-sensitivity (up minus down, { $gain }; 1: in full, 0: absent)
earth-rotation-vertical-not-shown = The data do not show Earth's rotation (up minus down, { $gain }; 1: in full, 0: absent), unless a g-sensitivity of the opposite sign hides it
earth-rotation-scale-factor-assumed = Where this run gives no gyro scale factor, 1 was taken to remove Earth's rotation.
