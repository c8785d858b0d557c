## Items of the specifications and their elements. $reads: the axis that reads; $input: the input axis.

item-gyro-scale-factor = Gyro scale factor
    .element = Scale factor of the { $reads } gyro
item-gyro-fit-offset = Gyro fit offset
    .element = Fit offset of the { $reads } gyro
item-gyro-bias = Gyro bias
    .element = Bias of the { $reads } gyro
item-gyro-cross-coupling = Gyro cross coupling coefficient
    .element = Coupling of the { $input } axis onto the { $reads } gyro
item-gyro-g-sensitivity = Gyro g-sensitivity
    .element = { $input } acceleration onto the { $reads } gyro
item-accel-scale-factor = Accelerometer scale factor
    .element = Scale factor of the { $reads } accelerometer
item-accel-bias = Accelerometer bias
    .element = Bias of the { $reads } accelerometer
item-accel-cross-coupling = Accelerometer cross coupling coefficient
    .element = Coupling of the { $input } axis onto the { $reads } accelerometer
item-accel-rate-sensitivity = Accelerometer rate sensitivity
    .element = { $input } rate onto the { $reads } accelerometer
item-ahrs-scale-factor = Scale factor
    .element = Scale factor of the { $reads } axis
item-ahrs-zero-offset = Zero offset
    .element = Zero offset of the { $reads ->
        [X] heading
        [Y] pitch
       *[Z] roll
    } angle
item-ahrs-misalignment = Misalignment angle
    .element = Misalignment of the { $input } axis to the { $reads } axis
