## What the reference of a recording tells, and what was not taken from it.

reference-smoothed = The poses were smoothed by their own noise: rates are the derivative of the attitude up to { $attitude } Hz, the specific force has the second derivative of the positions up to { $place } Hz. Above, the poses' noise is larger than the motion, and nothing was compared.
reference-smoothed-attitude = The poses were smoothed by their own noise: rates are the derivative of the attitude up to { $attitude } Hz. Above, the poses' noise is larger than the motion, and nothing was compared.
reference-without-positions = The poses have no positions (px, py, pz): the specific force of a body that moves is not known. The accelerometers were compared where it rests, { $percent } % of the time; record positions, too.
reference-lost = The poses say nothing during { $percent } % of the recording: across more than { $frames } missing frames nothing was interpolated, nor was anything compared.
reference-labels-against-gravity = Labels that gravity contradicts were left out: { $segments }.
reference-labels-against-rate = Labels whose rate the { $table ->
    [yes] encoders contradict
   *[no] gyros contradict
} were left out: { $segments }.
reference-nuisances = A delay of the poses and a vertical that leans are usual between tracking and unit. Both are fitted in every model of such a recording, and are no faults of the unit.
reference-turned = The tracked body's axes are turned by { $degrees } deg against the unit's. That is usual; the matrices of scale factors and cross couplings hold it, and are not those of the unit alone.
reference-unit-clock = The station held the unit's clock against the table's as its frames arrived: of a delay of the readings, { $delay } ms ± { $U } ms (k = 2) are the clocks'. What is found beyond is the unit's own.
