## The clauses of JJF 2003-2022: what is missing, what was not as the clause asks.

jjf2003-triad-gyro = gyro
jjf2003-triad-accel = accelerometer
jjf2003-triad-gyro-and-accel = gyro and accelerometer

jjf2003-positions-missing = No usable rest with { $ups } up of the { $triads } triad; 7.2.2.1 requires all six.
jjf2003-one-heading = { $ups } up: { $triads } not recorded at two headings 180° apart as 7.2.2.1 requires; the horizontal components of Earth's rotation and of the table's tilt do not cancel.
jjf2003-no-rest-gyro = no usable rest with an axis up or down that includes the gyro triad
jjf2003-no-rest-accel = no usable rest with an axis up or down that includes the accelerometer triad
jjf2003-position-missing = { $elements }: no rest with { $ups } up
jjf2003-positions-scatter = The positions disagree with the model by more than the noise explains ({ $channels } times); the uncertainties were increased accordingly.

jjf2003-latitude-unknown = without Earth rotation: the latitude is not stated
jjf2003-horizontal-unknown = without Earth rotation, off the diagonal: { $ups } held at one heading only, so the horizontal component is unknown
jjf2003-earth-rotation-present = { $shown }. By eq. (7) the diagonal of the g-sensitivity includes { $rate } (deg/s)/g of it at { $latitude }° latitude; the value without it is given alongside.
jjf2003-earth-rotation-not-visible = { $shown }. A unit at rest on the Earth reads { $rate } (deg/s)/g on the diagonal by eq. (7) at { $latitude }° latitude; the value without this contribution is given alongside.
jjf2003-earth-rotation-not-shown = { $shown }. The value without Earth's rotation nevertheless has { $rate } (deg/s)/g ({ $latitude }° latitude) subtracted from the diagonal, as for a station that rotates with the Earth. Do not use it for simulated or compensated data, from which it would be removed twice: their value is that by eq. (7).
jjf2003-earth-rotation-odd = { $shown }. A unit at rest on the Earth reads { $rate } (deg/s)/g on the diagonal by eq. (7) at { $latitude }° latitude; the value without this contribution is given alongside.

jjf2003-no-line = { $axes }: eq. (4) requires at least two constant rates about the axis
jjf2003-line-scatter = Rotating about { $axis }, the points scatter about the line of eq. (4) by more than the noise explains ({ $channels } times); the uncertainties were increased accordingly.
jjf2003-turned-angle = The scale factor was determined from turns by a known angle, not from constant rates as in 7.2.1.

jjf2003-no-rate = no usable rate about { $axis } with accelerometer readings
jjf2003-not-vertical = gravity is not along { $axis } during rotation, or the recording does not say
jjf2003-no-rest-beside = no rest with { $axis } up or down
jjf2003-p-one-direction = { $axis } axis: p is based on one direction of rotation; contributions that change sign with the direction do not cancel.
jjf2003-p-no-rest-after = { $axis } axis: p has no rest after the rotation; accelerometer drift does not cancel.
jjf2003-p-no-rest-before = { $axis } axis: p has no rest before the rotation; accelerometer drift does not cancel.

## Sections of the certificate's results.

section-scale-factors = Scale factors
section-biases = Biases
section-gyro-cross-coupling = Gyro cross coupling coefficients
section-accel-cross-coupling = Accelerometer cross coupling coefficients
section-gyro-g-sensitivity = Gyro g-sensitivity (g)
section-accel-rate-sensitivity = Accelerometer rate sensitivity (p)
