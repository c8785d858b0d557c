## What the reference of a recording tells, and what was not taken from it.

reference-smoothed = The poses were smoothed according to their own noise: rates are the derivative of the attitude up to { $attitude } Hz, and specific force includes the second derivative of the positions up to { $place } Hz. Above these frequencies the noise of the poses exceeds the motion, and nothing was compared.
reference-smoothed-attitude = The poses were smoothed according to their own noise: rates are the derivative of the attitude up to { $attitude } Hz. Above this frequency the noise of the poses exceeds the motion, and nothing was compared.
reference-without-positions = The poses contain no positions (px, py, pz), so the specific force of a moving body is unknown. The accelerometers were compared only at rest, { $percent } % of the time; record positions as well.
reference-lost = Nothing was compared during { $unknown } % of the recording: poses are missing during { $missing } %, where gaps of more than { $frames } frames were not interpolated, and beside each gap and at both ends their derivatives are not known.
reference-labels-against-gravity = Labels contradicted by gravity were excluded: { $segments }.
reference-rests-disturbed = { $rows } rows in { $segments } lie far from the rest of their segment, as if the unit had been touched or were already moving; they were not used.
reference-labels-against-rate = Labels whose rate the { $table ->
    [yes] encoders contradict
   *[no] gyros contradict
} were excluded: { $segments }.
reference-nuisances = A delay of the poses and a tilted vertical are normal between tracking system and unit. Both are fitted as nuisance parameters in every model of such a recording and are not faults of the unit.
reference-turned = The axes of the tracked body are rotated by { $degrees }° relative to those of the unit, for both triads alike. This is normal; the poses were turned by it, so that they are those of the unit.
reference-triads-apart = Against the tracked body, the gyros' axes are arranged differently from those of the accelerometers: columns of one triad are exchanged or inverted, which no mounting does. Nothing was turned; compare both triads with the drawing, and import the recording with --axes.
reference-unit-clock = The station compared the clocks of unit and table as frames arrived: of the delay of the readings, { $delay } ms ± { $U } ms (k = 2) is due to the clocks. Any delay found beyond that belongs to the unit.
reference-slow = The table's angles were recorded every { $every } s, too slowly to show how the rate changed in between: { $percent } % of the recording, in ramps and beside them, was not compared.
