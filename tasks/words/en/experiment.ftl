# The recording that decides.
next-title = The recording that decides
next-decides = A recording of { $minutes } min is expected to name { $effects } for certain: a χ² of { $left } beyond the nearest other, and the right name alone in { $percent } % of recordings. The same recording once more ({ $base } min) would show { $repeated }.
next-decides-by-silence = A recording of { $minutes } min in which the unit is heated and cooled is expected to tell { $effects }: a χ² of { $left } beyond the nearest other, and the right name alone in { $percent } % of recordings; where no bias follows the chamber, it is { $silent }. The same recording once more ({ $base } min) would show { $repeated }.
next-undecided = No recording of { $longest } min that this station can make names { $effects } for certain: the best one shows a χ² of { $left } beyond the nearest other where { $needed } is needed, and names the right one alone in { $percent } % of recordings. { $why } What would tell: { $other }.
next-impossible = No recording of { $longest } min that this station can make names { $effects } for certain: the best one shows a χ² of { $left } beyond the nearest other where { $needed } is needed, and names the right one alone in { $percent } % of recordings. { $why } Or name another station (--station).
next-nothing-moves = Whatever this table does, they change the readings alike.
next-too-little = At the table's rates they differ by so little that it would take about { $hours } h.
next-longer = More of the same is expected to do: about { $minutes } min (--minutes { $minutes }).
next-or = { $first }; or { $rest }
