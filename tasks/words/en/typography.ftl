## How clauses, equations and ranges are written.

# The script that a certificate is set in, and the region of its letterforms.
typography-script = latin
    .region = {""}
typography-specification = JJF { $number }-{ $year }
typography-equation = { $number }
typography-equations = eq. { $numbers }
    .range = eq. { $first }–{ $last }
typography-range = ~
typography-list-under = list under { $equation }
typography-appendix = Appendix { $letter }
    .entry = Appendix { $letter }, { $entry }
typography-table = Table { $number }
typography-from-to = {" to "}
typography-and = {" and "}
    .equations = {" and "}
typography-comma = {", "}
    .equation = {", "}
typography-joint-method = , joint method
    .gravity = , joint method with gravity alone
