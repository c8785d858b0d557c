# 判别试验
next-title = 判别试验
next-decides = 预计 { $minutes } min 的一次记录即可{ $count ->
        [1] 确认
       *[other] 区分
    }{ $effects }：{ $count ->
        [1] 与最接近的其他解释
       *[other] 两者
    }相差的 χ² 为 { $left }，{ $percent } % 的记录能给出唯一正确的名称。原试验再做一遍（{ $base } min）只能得到 { $repeated }。
next-decides-by-silence = 预计 { $minutes } min 的一次升温、降温记录即可区分{ $effects }：与最接近者相差的 χ² 为 { $left }，{ $percent } % 的记录能给出唯一正确的名称；若零偏不随箱温变化，则为{ $silent }。原试验再做一遍（{ $base } min）只能得到 { $repeated }。
next-undecided = 本台站在 { $longest } min 内所能做的任何记录都不能{ $count ->
        [1] 确认
       *[other] 区分
    }{ $effects }：最好的一种{ $count ->
        [1] 与最接近的其他解释
       *[other] {""}
    }相差的 χ² 为 { $left }，而需要 { $needed }；{ $percent } % 的记录能给出唯一正确的名称。{ $why }可用以下试验区分：{ $other }。
next-impossible = 本台站在 { $longest } min 内所能做的任何记录都不能{ $count ->
        [1] 确认
       *[other] 区分
    }{ $effects }：最好的一种{ $count ->
        [1] 与最接近的其他解释
       *[other] {""}
    }相差的 χ² 为 { $left }，而需要 { $needed }；{ $percent } % 的记录能给出唯一正确的名称。{ $why }也可指定其他台站（--station）。
next-nothing-moves = 在本转台编码器所能分辨的范围内，无论其如何运动，{ $count ->
        [1] 其影响与其他解释无从区别
       *[other] 它们对读数的影响都相同
    }。
next-too-little = 在本转台的速率下{ $count ->
        [1] 其与其他解释
       *[other] 它们
    }相差太小，约需 { $hours } h。
next-longer = 延长同样的试验预计即可区分：约 { $minutes } min（--minutes { $minutes }）。
next-found-longer = { $needs } min 的记录即可（--minutes { $minutes }）。
next-or = { $first }；或{ $rest }
