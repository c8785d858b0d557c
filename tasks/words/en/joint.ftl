## The joint method: why elements are missing, and what the reader of its result must know.

joint-of-elements = { $elements }: { $reason }
joint-not-distinguished = the segments of this run cannot separate it from the other parameters
joint-not-turned-gyro = fewer than two known rates about { $axes } with gyro readings
joint-not-turned-accel = no known rate about a known vertical about { $axes } with accelerometer readings
joint-no-rest-gyro = no rest with { $ups } up and gyro readings
joint-no-rest-accel = no rest with { $ups } up and accelerometer readings
joint-horizontal-unknown = off the diagonal, { $ups } held at one heading only and north is not stated, so the horizontal component of Earth's rotation is unknown

joint-number-of-rates = Fewer than { $fewest } rates: { $rates }; the joint method requires { $fewest } or more in both directions about each axis, including the largest.
joint-orientations-not-turned = Not rotated with { $ups } up; claim 3 rotates in all six orientations.
joint-rates-not-rising = { $axes }: the rates were not taken in ascending order as claim 4 specifies.

joint-earth-not-removed = The latitude is not stated: Earth's rotation was not removed, and the diagonal of the g-sensitivity includes its vertical component.
joint-earth-not-shown = { $shown }. It was not subtracted: bias and g-sensitivity are as in the data.
joint-earth-removed = { $shown }. At { $latitude }° latitude it was subtracted as a known input: bias and g-sensitivity are given without it.
joint-north-unknown = The direction of north in the rests is not stated: only the vertical component of Earth's rotation was removed; the horizontal component cancels between two headings 180° apart and otherwise remains in the bias.
joint-scatter = The segments disagree with the model by more than the noise explains ({ $channels } times); the uncertainties were increased accordingly.

## The joint method with gravity alone: rests and moves by hand.

joint-gravity-alone = No table and no labels: gravity was the only reference, in rests detected in the data.
joint-gravity-residual = The specific force of the { $rests } rests deviates from gravity by { $rms } m/s² (rms), no more than the noise explains.
joint-gravity-residual-excess = The specific force of the { $rests } rests deviates from gravity by { $rms } m/s² (rms), { $factor } times what the noise explains; the uncertainties were increased accordingly.
joint-moves-residual = Over { $moves } moves the integrated gyro deviates from the vertical by { $angle }° (rms); the uncertainties of the gyro are derived from this scatter.
joint-vertical-removed = Only the vertical component of Earth's rotation was removed: the direction of north in the rests is unknown.
joint-no-moves = fewer than nine moves between rests rotate the unit about all of its axes with both triads recorded
joint-coupling-by-definition = zero by definition: the accelerometers' own axes are the reference
joint-no-rate-held = no known constant rate
joint-few-rests = { $rests } rests with accelerometer readings; { $fewest } or more at well distributed attitudes are required
