## Events: artefacts of the readings, as findings and remarks describe them.

events-saturation = the { $sensors } clip at { $limit }: { $count } readings lie at this limit and none beyond
events-plateau = the { $sensors } stay constant while the predicted readings continue to change: { $limits }
events-plateau-at = { $channel } at { $limit } ({ $count } predicted readings beyond)
events-quantisation = the { $sensors } have a resolution of { $step }, { $ratio } times the noise
events-code-fault = wrong output codes: { $channels }
events-code-fault-title = wrong output codes in the { $channels }: { $bugs }
events-code-fault-at = { $channel } is off by whole multiples of { $size } ({ $jump }) in { $share } % of the readings, depending on the code
events-repeats = rows without information of their own: { $kinds }
events-repeats-held = the { $sensors } repeat the preceding row in { $count } rows ({ $share } %)
events-repeats-doubled = { $count } rows of the { $sensors } are duplicated ({ $share } %), which shifts later time stamps
events-repeats-interpolated = the { $sensors } lie on a straight line between their neighbours in { $count } rows ({ $share } %)
events-dead-zone = small readings are set to zero: { $limits }
events-dead-zone-at = { $channel } below { $threshold } ({ $count } readings)
events-dead-zone-less = { $channel } below { $threshold } ({ $count } readings); the same threshold is subtracted from all larger readings
events-zeroed = in { $rests } rests the bias of the { $channels } was re-estimated and subtracted: their means are zero
events-bias-at-rest = whenever no rate exceeds ±{ $quiet } rad/s for { $wait } s, the bias of the { $channels } is estimated with a time constant of { $tau } s and subtracted from all subsequent readings
events-jitter = the time stamps scatter by { $jitter } ms about evenly spaced instants, at which the readings were actually taken
events-lost-samples = samples were lost, which shifts later time stamps: { $losses }
events-lost-samples-at = { $lost } at { $time } s
events-gaps = the time stamps have { $gaps ->
        [one] { $gaps } gap
       *[other] { $gaps } gaps
    }, { $missing } sample intervals in total; the other stamps are correct, so this is not a mismatch
events-cut-off = the { $channel } reads { $share } % of what its motion gives, with less than half the noise of the others of its triad: check whether a limit of its range cuts it off
events-constant = the { $channels } read one value throughout and are not used: check the wiring, the logger and what the firmware suppresses
events-empty-rows = { $count ->
    [one] One row holds
   *[other] { $count } rows hold
 } zeros, or values far from those of the rows on either side (a frame that was corrupted, or a shock shorter than the time between rows), at t = { $times } s; not used.
events-settling-start = For { $seconds } s from the start, the { $channels } read values far from those that follow; these readings are not used.
events-settling-end = For the last { $seconds } s, the { $channels } read values far from those before; these readings are not used.
events-spikes = { $count } isolated readings in the { $channels } deviate from their neighbours by more than { $threshold } times the noise
events-spikes-in-rotation = { events-spikes }, only while the table turns
events-folded-mains = spectral line at { $line } Hz, where sampling folds mains of { $frequency } Hz
events-mains = mains pick-up at { $frequency } Hz, visible at { $lines }, in the { $channels }
events-line = a continuous spectral line at { $frequency } Hz in the { $channels }
events-bursts =
    { $count ->
        [one] 1 burst at { $frequency } Hz, decaying in { $decay } s, in the { $channels }, at { $times } s
       *[other] { $count } bursts at { $frequency } Hz, decaying in { $decay } s, in the { $channels }, at { $times } s
    }
events-range = the { $sensors } read { $factor } times the true value: { $cause }
events-range-counts = wrong counts per unit, or a wrong range setting
events-range-power-of-two = a range setting wrong by a power of two
events-range-degrees = degrees instead of radians
events-range-radians = radians converted as if they were degrees
events-range-gravities = units of g instead of m/s²
events-range-metric = m/s² converted as if they were units of g
events-range-thousand = thousandths of a unit instead of whole units, or the reverse
events-axis-mapping = axes of the { $sensors } are swapped or inverted: { $axes }
events-axis-reads = { $channel } reads { $sign }{ $axis }
