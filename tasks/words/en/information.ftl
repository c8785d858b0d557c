## What the data show beside the clauses' results. Titles by the key of the result; .text: how it was found.

information-earth-gain = Gain of Earth's rotation in the rests
    .text = { $shown }. λ = { $gain } ± { $spread } (k = 2; 1: in full, 0: absent); the ± is type A only: contributions of latitude, heading and placement are not evaluated, so no U is stated.
information-without-earth = Gyro g-sensitivity without Earth's rotation
    .text = The vertical component of Earth's rotation, ω_e·sin φ, is subtracted from the diagonal; { $difference } U is evaluated as for the item.
information-earth-present = the value by eq. (7) includes it and is off by up to { $times } times its U.
information-earth-not-shown = this changes it by up to { $times } times U, although the data do not show it: not to be used for simulated or compensated data, from which it would be removed twice.
information-earth-unknown = this changes it by up to { $times } times U. Whether the value by eq. (7) includes it cannot be decided from the data alone.

information-lever-arm = Position of the accelerometers relative to the rotation axes
    .text = One common point of the accelerometers, in the body frame, relative to the intersection of the rotation axes: from α × r in the ramps and ω × (ω × r) during rotation.
information-without-lever-arm = Accelerometer rate sensitivity without the lever arm
    .text = The value by eq. (12), (13) contains the lever arm; in the ramps the two can be separated. The sign is that of eq. (12).

information-nonlinearity = Scale factor non-linearity
    .text = Largest residual from the line through the rate points divided by the largest output; unit and table combined.
information-asymmetry = Scale factor asymmetry
    .text = Slope of the positive rates minus that of the negative rates, divided by their mean.
information-more-than-noise = Exceeds the noise: { $axes }.
information-no-more-than-noise = Within the noise on every axis.

information-gyro-bias-repeatability = Bias repeatability of the gyros
information-gyro-scale-repeatability = Scale factor repeatability of the gyros
information-accel-bias-repeatability = Bias repeatability of the accelerometers
information-accel-scale-repeatability = Scale factor repeatability of the accelerometers
information-ahrs-bias-repeatability = Bias repeatability of the axes
information-ahrs-scale-repeatability = Scale factor repeatability of the axes
information-repetition = Standard deviation of one repetition within this run; degrees of freedom: { $dof }.

information-gyro-angle-random-walk = Angle random walk of the gyros
information-gyro-bias-instability = Bias instability of the gyros
information-accel-velocity-random-walk = Velocity random walk of the accelerometers
information-accel-bias-instability = Bias instability of the accelerometers
information-ahrs-angle-random-walk = Angle random walk of the axes
information-ahrs-bias-instability = Bias instability of the axes
information-rests = { $count ->
        [1] 1 rest
       *[other] { $count } rests
    } of { $seconds } s
information-random-walk = White noise from the overlapping Allan deviation of { $source } (IEEE Std 952).
information-bias-instability = Minimum of the Allan deviation of { $source }, over 0.664.
information-noise-hidden = { $axes }: the noise is masked by the output's resolution.
information-no-white-noise = { $axes }: no white noise visible.
information-averaging-times = Averaging times: { $axes }.
information-no-floor = { $axes }: no floor up to an averaging time of { $tau } s; longer rests would be needed.

information-type-b =
    .contained = U includes type A and the type B contributions of the equipment.
    .not-evaluated = No U stated: the contributions of the equipment to this quantity were not evaluated.
    .in-part = { $elements }: no U stated, because the contributions of the equipment to these were not evaluated.
    .unit-and-table = A figure for unit and table combined: the equipment contributes nothing further to its U.
information-few-degrees-of-freedom = { $axes }: no U stated, because Student's t for so few degrees of freedom would extend below zero.
