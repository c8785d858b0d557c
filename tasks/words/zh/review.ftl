## 多次测量共同表明的内容。

review-carrier =
    .unit = 被校对象 { $name }
    .lot = 批次 { $name }
    .station = 工位 { $name }
    .model = 型号 { $name }
    .site = 场地 { $name }
review-carried = { $carrier } 的{ $runs ->
        [1] 1 次
       *[other] 各次
    }测量中存在{ $effect }
review-summary = 这些测量中发现 { $count } 项效应：{ $findings }
review-nothing = { $stations } 个工位上 { $units } 台被校对象的 { $runs } 次测量，除偶然因素或被校对象之间的分散所能造成者外，未见共同之处（{ $p }，已按全部检验次数修正；100 个无异常的机群中会有 1 个误报）
review-evidence = { $runs ->
        [1] 1 次测量显示该效应（仅由偶然造成的概率：{ $p }，已按全部检验次数修正）；该效应为其自身标准偏差的 { $z } 倍，该次测量{ $shown ->
            [0] 不倾向于存在该效应
           *[other] 倾向于存在该效应
        }
       *[other] { $runs } 次测量合计显示该效应（仅由偶然造成的概率：{ $p }，已按全部检验次数修正）；单次测量中为其自身标准偏差的 { $z } 倍（中位数），其中 { $shown } 次倾向于存在该效应
    }
review-sizes = { $sizes }
review-changed =
    .since = 自测量 { $run }（{ $at }；以 95 % 概率在 { $earliest } 与 { $latest } 之间）起存在
    .until = 至测量 { $run }（{ $at }；以 95 % 概率在 { $earliest } 与 { $latest } 之间）为止存在
    .since-certain = 自测量 { $run }（{ $at }；概率 95 % 以上）起存在
    .until-certain = 至测量 { $run }（{ $at }；概率 95 % 以上）为止存在
review-deciding-run =
    .unit = 这些测量无法区分{ $unit }与{ $station }：将该被校对象置于另一工位，或将另一被校对象置于该工位测量一次，即可区分
    .other = 这些测量无法区分{ $carrier }与{ $other }：仅涉及其中之一的一次测量即可区分
review-touches = 依据这些测量的 { $looked } 份证书中有 { $count } 份所载数值受其影响；影响最大的是 { $certificate }：{ $element }改变 { $times } U
review-touches-none = 依据这些测量的证书（{ $looked } 份）所载数值改变均不超过 0.05 U
review-other-names = 此处同样可能的是：{ $names }
review-separated-by = 可将其区分的测试：{ $recording }
review-site = { $station }：各清单均未给出，由 { $runs } 次测量中的地球自转估计：纬度 { $latitude }（北纬或南纬），航向 { $heading }（k = 2）
review-site-unknown = { $station }：各清单均未给出纬度与航向，其 { $runs } 次测量中的地球自转亦不明显
together-found = { $unit } 的 { $count } 次记录共同表明存在{ $effects }
together-nothing = { $unit } 的 { $count } 次记录合计未见偶然因素不能造成的差异（{ $p }，已按全部检验次数修正）
together-unnamed = { $unit } 的 { $count } 次记录合计偏离标准模型（{ $p }，已按全部检验次数修正），但目录中没有一种效应取值合理、且在未参与拟合的数据上同样成立
together-evidence = { $effect }：各次记录的证据合计 ΔBIC = { $gain }
together-alone = 单独解释 { $recording }：{ $verdict }
