## What many runs show together.

review-carrier =
    .unit = unit { $name }
    .lot = lot { $name }
    .station = station { $name }
    .model = model { $name }
    .site = site { $name }
review-carried = { $effect } in the { $runs ->
        [one] run
       *[other] runs
    } of { $carrier }
review-summary = { $count ->
        [one] One effect
       *[other] { $count } effects
    } found in these runs: { $findings }
review-nothing = { $runs } runs of { $units ->
        [one] one unit
       *[other] { $units } units
    } on { $stations ->
        [one] one station
       *[other] { $stations } stations
    } have nothing in common beyond chance and the spread between units ({ $p }, corrected for the number of tests; 1 clean fleet in 100 would raise a false alarm)
review-evidence = { $runs ->
        [one] One run shows it (by chance alone: { $p }, corrected for the number of tests); the effect is { $z } times its standard deviation, and the run { $shown ->
            [0] does not favour it
           *[other] favours it
        }
       *[other] { $runs } runs together show it (by chance alone: { $p }, corrected for the number of tests); in a single run the effect is { $z } times its standard deviation (median), and { $shown ->
            [0] none of them favours it
            [one] one of them favours it
           *[other] { $shown } of them favour it
        }
    }
review-sizes = { $sizes }
review-changed =
    .since = present since run { $run } ({ $at }; between { $earliest } and { $latest } with 95 % probability)
    .until = present until run { $run } ({ $at }; between { $earliest } and { $latest } with 95 % probability)
    .since-certain = present since run { $run } ({ $at }; 95 % interval contains no other run)
    .until-certain = present until run { $run } ({ $at }; 95 % interval contains no other run)
review-deciding-run =
    .unit = these runs cannot separate { $unit } from { $station }: a run of the unit on another station would, or one of another unit on this station
    .other = these runs cannot separate { $carrier } from { $other }: a run of one of them without the other would
review-touches = certificates on these runs that print affected values: { $count } of { $looked }; largest change: { $certificate }, { $element } by { $times } U
review-touches-none = no value printed on the certificates of these runs ({ $looked }) changes by more than 0.05 U
review-other-names = equally likely here: { $names }
review-separated-by = a recording that would separate them: { $recording }
review-site = { $station }: estimated from Earth's rotation in { $runs ->
        [one] one run
       *[other] { $runs } runs
    } because no manifest states it: latitude { $latitude } north or south, heading { $heading } (k = 2)
review-site-unknown = { $station }: no manifest states its latitude and heading, and Earth's rotation is not significant in its { $runs ->
        [one] only run
       *[other] { $runs } runs
    }
together-found = { $count } recordings of { $unit } together show { $effects }
together-nothing = { $count } recordings of { $unit } together show nothing beyond chance ({ $p }, corrected for the number of tests)
together-unnamed = { $count } recordings of { $unit } together depart from the standard's model ({ $p }, corrected for the number of tests), but no effect in the catalogue has plausible values that also hold where they were not fitted
together-evidence = { $effect }: the combined evidence of the recordings is ΔBIC = { $gain }
together-alone = { $recording } alone: { $verdict }
