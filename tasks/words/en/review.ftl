## What many runs show together.

review-carrier =
    .unit = unit { $name }
    .lot = lot { $name }
    .station = station { $name }
    .model = model { $name }
    .site = site { $name }
review-carried = { $effect } in the runs of { $carrier }
review-summary = { $count ->
        [one] One effect that
       *[other] { $count } effects that
    } the runs have in common: { $findings }
review-nothing = { $runs } runs of { $units ->
        [one] one unit
       *[other] { $units } units
    } on { $stations ->
        [one] one station
       *[other] { $stations } stations
    } have nothing in common that chance, or a spread between units, would not show as well ({ $p }, corrected for all that was tried; 1 clean fleet in 100 would raise a false alarm)
review-evidence = { $runs ->
        [one] One run has
       *[other] { $runs } runs add up to
    } χ² = { $gain }; in a single one it is { $z } times its own standard deviation (median), and { $shown } of them lean towards it
review-sizes = { $sizes }
review-changed =
    .since = it is there since run { $run } ({ $at }; between { $earliest } and { $latest } with 95 % probability)
    .until = it is there up to run { $run } ({ $at }; between { $earliest } and { $latest } with 95 % probability)
    .since-certain = it is there since run { $run } ({ $at }; with 95 % probability no other)
    .until-certain = it is there up to run { $run } ({ $at }; with 95 % probability no other)
review-deciding-run =
    .unit = these runs do not tell { $unit } from { $station }: a run of the unit on another station would, or one of another unit on this station
    .other = these runs do not tell { $carrier } from { $other }: a run of one of them without the other would
review-touches = certificates on these runs that print what it moves: { $count } of { $looked }; most of all { $certificate }, { $element } by { $times } U
review-touches-none = nothing that the certificates on these runs print ({ $looked }) is moved by more than 0.05 U
review-other-names = as likely here: { $names }
review-separated-by = what would separate them: { $recording }
review-site = { $station }: estimated from Earth's rotation in { $runs } runs, as no manifest gives it: latitude { $latitude } north or south, heading { $heading } (k = 2)
review-site-unknown = { $station }: no manifest gives its latitude and heading, and Earth's rotation does not stand out in its { $runs } runs
together-found = { $count } recordings of { $unit } together show { $effects }
together-nothing = { $count } recordings of { $unit } together show nothing that chance would not show as well ({ $p }, corrected for all that was tried)
together-evidence = { $effect }: the evidence of the recordings adds up to ΔBIC = { $gain }
together-alone = { $recording } by itself: { $verdict }
