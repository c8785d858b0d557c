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
