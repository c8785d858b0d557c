# The recording that decides.
next-title = The recording that decides
next-decides = A recording of { $minutes } min is expected to tell { $effects }: χ² of { $left } between them, the right name alone in { $percent } % of recordings. The same recording once more ({ $base } min) would show { $repeated }.
next-undecided = No recording of { $longest } min that this station can make tells { $effects }: the best one shows a χ² of { $left } between them, which names the right one alone in { $percent } % of recordings. What would: { $other }.
next-impossible = No recording of { $longest } min that this station can make tells { $effects }: the best one shows a χ² of { $left } between them, which names the right one alone in { $percent } % of recordings. Record longer (--minutes), or name another station (--station).
