# 判别试验
next-title = 判别试验
next-decides = 预计 { $minutes } min 的一次记录即可区分{ $effects }：两者相差的 χ² 为 { $left }，{ $percent } % 的记录能给出唯一正确的名称。原试验再做一遍（{ $base } min）只能得到 { $repeated }。
next-undecided = 本台站在 { $longest } min 内所能做的任何记录都不能区分{ $effects }：最好的一种相差的 χ² 为 { $left }，{ $percent } % 的记录能给出唯一正确的名称。可用以下试验区分：{ $other }。
next-impossible = 本台站在 { $longest } min 内所能做的任何记录都不能区分{ $effects }：最好的一种相差的 χ² 为 { $left }，{ $percent } % 的记录能给出唯一正确的名称。请延长记录（--minutes）或指定其他台站（--station）。
