## The joint method: why elements are missing, and what the reader of its result must know.

joint-of-elements = { $elements }: { $reason }
joint-not-distinguished = the segments of this run do not tell it apart from the rest
joint-not-turned-gyro = fewer than two known rates about { $axes } with the gyro triad recorded
joint-not-turned-accel = no known rate about a known vertical about { $axes } with the accel triad recorded
joint-no-rest-gyro = no rest with { $ups } up and the gyro triad recorded
joint-no-rest-accel = no rest with { $ups } up and the accel triad recorded
joint-horizontal-unknown = off the diagonal, { $ups } held at one heading only and north is not stated, so the horizontal part of Earth's rotation is not known

joint-number-of-rates = Fewer than { $fewest } rates: { $rates }; the joint method asks for { $fewest } or more forward and back about each axis, the largest included.
joint-orientations-not-turned = Not turned with { $ups } up; claim 3 turns in all six orientations.
joint-rates-not-rising = { $axes }: the rates were not taken in rising order, as claim 4 has it.

joint-earth-not-removed = The latitude is not stated: Earth's rotation was not removed, and the diagonal of the g-sensitivity contains its vertical part.
joint-earth-not-shown = { $shown }. It was not taken off: bias and g-sensitivity are as the data have them.
joint-earth-removed = { $shown }. At { $latitude }° latitude it was taken off as a known input: bias and g-sensitivity are given without it.
joint-north-unknown = Where north lay in the rests is not stated: only the vertical part of Earth's rotation was removed; the horizontal part cancels between two headings 180° apart and is else in the bias.
joint-scatter = The segments disagree with the model more than the noise explains ({ $channels } times); the uncertainties were enlarged by as much.

## The joint method with gravity alone: rests and moves by hand.

joint-gravity-alone = No table and no labels: gravity was the only reference, in rests found in the data.
joint-gravity-residual = The specific force of the { $rests } rests misses gravity by { $rms } m/s² (rms), no more than the noise explains.
joint-gravity-residual-excess = The specific force of the { $rests } rests misses gravity by { $rms } m/s² (rms), { $factor } times what the noise explains; the uncertainties were enlarged by as much.
joint-moves-residual = Over { $moves } moves the integrated gyro misses the vertical by { $angle }° (rms); the gyro's uncertainties are from this scatter.
joint-vertical-removed = Only the vertical part of Earth's rotation was removed: where north lay in the rests is not known.
joint-no-moves = no nine moves between rests turn the unit about all of its axes with both triads recorded
joint-coupling-by-definition = zero by definition, the accelerometers' own axes are the reference
joint-no-rate-held = no known rate was held
joint-few-rests = { $rests } rests with the accelerometers; { $fewest } or more at attitudes all around are needed
