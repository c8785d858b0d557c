# The recording that decides.
next-title = The deciding recording
next-decides = A recording of { $minutes } min is expected to identify { $effects } reliably: it separates { $count ->
        [one] it
       *[other] them
    } from the nearest alternative by χ² = { $left } and yields the correct name alone in { $percent } % of recordings. Repeating the same recording ({ $base } min) would give { $repeated }.
next-decides-by-silence = A recording of { $minutes } min in which the unit is heated and cooled is expected to separate { $effects } from the nearest alternative by χ² = { $left } and to yield the correct name alone in { $percent } % of recordings; if no bias follows the chamber, it is { $silent }. Repeating the same recording ({ $base } min) would give { $repeated }.
next-undecided = No recording of { $longest } min that this station can make identifies { $effects } reliably: the best one separates { $count ->
        [one] it
       *[other] them
    } from the nearest alternative by χ² = { $left } where { $needed } is required, and yields the correct name alone in { $percent } % of recordings. { $why } What would decide: { $other }.
next-impossible = No recording of { $longest } min that this station can make identifies { $effects } reliably: the best one separates { $count ->
        [one] it
       *[other] them
    } from the nearest alternative by χ² = { $left } where { $needed } is required, and yields the correct name alone in { $percent } % of recordings. { $why } Alternatively name another station (--station).
next-nothing-moves = As far as the encoders of this table resolve its motion, { $count ->
        [one] it affects the readings no differently from the nearest alternative
       *[other] they affect the readings in the same way
    } whatever it does.
next-too-little = At the table's rates { $count ->
        [one] it differs so little from the nearest alternative
       *[other] they differ so little
    } that about { $hours } h would be required.
next-longer = A longer recording of the same kind is expected to suffice: about { $minutes } min (--minutes { $minutes }).
next-found-longer = A recording of { $needs } min would (--minutes { $minutes }).
next-or = { $first }; or { $rest }
