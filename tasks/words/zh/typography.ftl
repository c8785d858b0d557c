## How clauses, equations and ranges are written.

# The script that a certificate is set in, and the region of its letterforms.
typography-script = han
    .region = cn
typography-specification = JJF { $number }—{ $year }
typography-equation = 式{ $number }
typography-equations = { $numbers }
    .range = 式{ $first }～式{ $last }
typography-range = ～
typography-list-under = { $equation }下列表
typography-appendix = 附录 { $letter }
    .entry = 附录 { $letter } 第 { $entry } 项
typography-table = 表 { $number }
typography-from-to = ～
typography-and = 和
    .equations = 、
typography-comma = ，
    .equation = {" "}
typography-joint-method = （联合法）
    .gravity = （联合法，仅以重力为参考）
