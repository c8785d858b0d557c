## What the command line asks the person at the terminal.

flows-press-enter = Then press Enter.

# The picture of a re-processing.
changed-title = What moved in { $done } { $done ->
        [one] result
       *[other] results
    }, of which { $unchanged } { $unchanged ->
        [one] is as it was
       *[other] are as they were
    }
changed-in-U = change of the value / U, from { $least } on
changed-in-part = change of the value / U, from { $least } on; ×: determined before or now only
changed-nothing = nothing moved
flows-who-operates = Operator (full name, as on the certificate):

# What the terminal says of results.
flows-run =
    .valid = the run is valid
    .remarks = the run is valid with remarks, on which no unit passes
    .invalid = the run is invalid, and nothing is decided on the unit
flows-not-determined = not determined
flows-for-information = for information, not decided on
flows-column =
    .item = item
    .quantity = quantity
    .value = value
    .unit = unit
    .missing = missing
    .share = share
    .channels = channels
    .parameter = parameter
    .effect = effect
    .carrier = carrier
    .since = since
    .runs = runs
flows-due = recalibration due { $day }
flows-next =
    .draft = next: mimucal check { $number } --by NAME, then mimucal issue { $number } --by NAME
    .checked = next: mimucal issue { $number } --by NAME
flows-left-over = left over, χ² per degree of freedom: { $channels }
flows-more-elements = and { $count } elements more, in the report
flows-verdict-of = verdict of { $item }: { $change }
flows-left-out = left out: { $run }: { $why }
flows-of-runs = { $verdict } ({ $runs } runs)
