## What the data show beside the clauses' results. Titles by the key of the result; .text: how it was found.

information-earth-gain = Gain of Earth's rotation in the rests
    .text = { $shown }. The ± is of type A alone: what latitude, heading and placing add is not evaluated, so the figure stands without U.
information-without-earth = Gyro g-sensitivity without Earth's rotation
    .text = The vertical part of Earth's rotation, ω_e·sin φ, is taken off the diagonal; { $difference } U is evaluated as the item's.
information-earth-present = the value by eq. (7) contains it and is off by up to { $times } times its U.
information-earth-not-shown = this moves it by up to { $times } times U, although the data do not show it: not to be used for simulated or compensated data, from which it would be removed twice.
information-earth-unknown = this moves it by up to { $times } times U. Whether the value by eq. (7) contains it cannot be decided from the data alone.

information-lever-arm = Place of the accelerometers from the rotation axes
    .text = One common point of the accelerometers, in the body frame, from where the rotation axes meet: from α × r in the ramps and ω × (ω × r) while turning.
information-without-lever-arm = Accelerometer rate sensitivity without the lever arm
    .text = The value by eq. (12), (13) contains the lever arm; in the ramps the two can be separated. The sign is that of eq. (12).

information-nonlinearity = Scale factor non-linearity
    .text = Largest residual from the line through the rate points, over the largest output; unit and table together.
information-asymmetry = Scale factor asymmetry
    .text = Slope of the positive rates less that of the negative ones, over their mean.
information-more-than-noise = More than noise: { $axes }.
information-no-more-than-noise = No more than noise on any axis.

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
information-noise-hidden = { $axes }: the output's step hides the noise.
information-no-white-noise = { $axes }: white noise does not show.
information-averaging-times = Averaging times: { $axes }.
information-no-floor = { $axes }: no floor up to an averaging time of { $tau } s; longer rests would show it.

information-type-b =
    .contained = U contains type A and the type B of the equipment.
    .not-evaluated = Without U, because the limits of the equipment are in no budget of this run.
    .unit-and-table = A figure of unit and table together: the equipment adds nothing more to its U.
information-few-degrees-of-freedom = { $axes }: without U, which by Student's t for so few degrees of freedom would reach below zero.
