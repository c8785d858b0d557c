## Events: artefacts of the readings, as findings and remarks describe them.

events-saturation = the { $sensors } stop at { $limit }: { $count } readings lie there and none beyond
events-plateau = the { $sensors } stay where they are while what is predicted goes on: { $limits }
events-plateau-at = { $channel } at { $limit } ({ $count } readings beyond)
events-quantisation = the { $sensors } step by { $step }, { $ratio } times the noise
events-code-fault = the codes are wrong: { $channels }
events-code-fault-at = { $channel } is off by whole multiples of { $codes } codes ({ $jump }) in { $share } % of the readings, as the code decides
events-repeats = rows that say nothing of their own: { $kinds }
events-repeats-held = the { $sensors } hold the row before in { $count } rows ({ $share } %)
events-repeats-doubled = { $count } rows of the { $sensors } are there twice ({ $share } %), and later time stamps slip
events-repeats-interpolated = the { $sensors } lie on the line between their neighbours in { $count } rows ({ $share } %)
events-dead-zone = small readings are set to zero: { $limits }
events-dead-zone-at = { $channel } below { $threshold } ({ $count } readings)
events-dead-zone-less = { $channel } below { $threshold } ({ $count } readings), which is taken off all larger ones
events-zeroed = in { $rests } rests the bias is estimated anew and taken off, in the { $channels }: their means lie at zero
events-bias-at-rest = while no rate has left ±{ $quiet } rad/s for { $wait } s the bias is estimated, with a time constant of { $tau } s, and taken off all readings of the { $channels } from then on
events-jitter = the time stamps scatter by { $jitter } ms about even instants, at which the readings were taken
events-lost-samples = samples are lost and later time stamps slip: { $losses }
events-lost-samples-at = { $lost } at { $time } s
events-gaps = the time stamps have { $gaps ->
        [one] { $gaps } gap
       *[other] { $gaps } gaps
    }, of { $missing } sample intervals in all; the other stamps are right, so that this is no mismatch
events-spikes = { $count } single readings stand out from their neighbours by more than { $threshold } times the noise, in the { $channels }
events-spikes-in-rotation = { events-spikes }, only while the table turns
events-mains = mains pick-up of { $frequency } Hz, seen at { $lines }, in the { $channels }
events-line = a line at { $frequency } Hz, there all the time, in the { $channels }
events-impacts = clicks { $per_turn } times a turn of the outer axis, in the { $channels }
events-bursts =
    { $count ->
        [one] 1 burst of { $frequency } Hz that fades in { $decay } s, in the { $channels }, at { $times } s
       *[other] { $count } bursts of { $frequency } Hz that fade in { $decay } s, in the { $channels }, at { $times } s
    }
events-range = the { $sensors } read { $factor } times what they should: { $cause }
events-range-counts = the counts per unit, or the range, are set wrong
events-range-power-of-two = a range setting a power of two off
events-range-degrees = degrees where radians are meant
events-range-radians = radians converted as if they were degrees
events-range-gravities = units of g where m/s² are meant
events-range-metric = m/s² converted as if they were units of g
events-range-thousand = thousandths of a unit where whole units are meant, or the reverse
events-axis-mapping = the { $sensors } are exchanged or inverted: { $axes }
events-axis-reads = { $channel } reads { $sign }{ $axis }
