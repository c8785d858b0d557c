## 记录不可能如此之处，各以一句说明。$option：mimucal import 的选项。

plausibility-time = { $what ->
        [labels] 标注时刻达到 { $value }，为记录长度的 { $factor } 倍
       *[other] 时间长了 { $factor } 倍（相邻行相距 { $value } s）
    }：是否以{ $unit ->
        [ms] 毫秒
        [us] 微秒
       *[ns] 纳秒
    }为单位？请以 { $option } 重新导入。
plausibility-gravity-removed = 静止时加速度计读数为 { $read } m/s²：重力已被扣除；请记录扣除之前的读数。
plausibility-force-unit = 静止时加速度计读数为 { $read } m/s²，为当地重力加速度（{ $gravity } m/s²）的 { $ratio } 倍：{ $advised ->
        [yes] 其单位似为 { $unit }（相差 { $off } %）；请以 { $option } 导入
       *[no] 没有一种常用的比力单位能使各静止段均为此值且数字与之相符；请检查量程、计数当量和各列
    }。
plausibility-force-setting = 静止时加速度计读数为 { $read } m/s²，为当地重力加速度（{ $gravity } m/s²）的 { $ratio } 倍，各轴相同：器件自身的标度因数不会全部如此偏离 1；记录器的量程或每 g 计数设置有误。
plausibility-rate-setting = 陀螺读数为{ $source ->
        [table] 编码器所示角速率
        [pose] 位姿所示角速率
       *[labels] 标注角速率
    }的 { $ratio } 倍，各轴相同：器件自身的标度因数不会全部如此偏离 1；记录器的量程或每 °/s 计数设置有误。
plausibility-rate-unit = 陀螺读数为{ $source ->
        [table] 编码器所示角速率
        [pose] 位姿所示角速率
        [gravity] 各静止段间重力所示转角
       *[labels] 标注角速率
    }的 { $ratio } 倍：{ $advised ->
        [yes] 其单位似为 { $unit }（相差 { $off } %）；请以 { $option } 导入{ $source ->
            [labels] ；若标注有误，则将 rate_deg_s 改为 °/s
           *[other] {""}
        }
       *[no] 没有一种常用的角速率单位与此值及其数字相符；请检查量程、计数当量和各列
    }。
plausibility-table-unit = 编码器转过的角度为陀螺所示的 { $ratio } 倍：其单位似为度；请以 { $option } 导入。
plausibility-label-unit = { $count } 段的 rate_deg_s 单位有误：{ $segment } 标注为 { $label } °/s，而陀螺读数为 { $read } °/s，相差 57.3 倍；请将 rate_deg_s 改为 °/s、陀螺改为 rad/s，或以 --units 导入。
plausibility-axes = 各轴与标注或转台不符：{ $reads }（{ $value }）；请以 { $option } 导入。
plausibility-inverted = { $triad ->
        [gyro] 陀螺 { $axes } 轴方向相反
        [accel] 加速度计 { $axes } 轴方向相反
       *[both] 陀螺和加速度计的 { $axes } 轴方向均相反
    }
plausibility-exchanged = { $triad ->
        [gyro] 陀螺 { $axes } 轴互换
        [accel] 加速度计 { $axes } 轴互换
       *[both] 陀螺和加速度计的 { $axes } 轴均互换
    }
plausibility-turned = { $triad ->
        [gyro] 陀螺整体相对标注或安装转动
        [accel] 加速度计整体相对标注或安装转动
       *[both] 被校对象（陀螺和加速度计一同）整体相对标注或安装转动
    }，读数为 { $map }
plausibility-mirrored = { $triad ->
        [gyro] 陀螺各轴互换且反向
        [accel] 加速度计各轴互换且反向
       *[both] 陀螺和加速度计各轴同样互换且反向
    }，读数为 { $map }
plausibility-labels-shifted = 全部标注在时间上{ $late ->
        [late] 晚了
       *[early] 早了
    } { $seconds } s（± { $within } s）；请以 { $option } 导入。
plausibility-mount = 被校对象相对标注或转台所称各轴绕（{ $axis }）转过 { $degrees }°，陀螺与加速度计相同：轴的互换不能如此；请沿各轴安放，或在记录中写明其安装姿态。
plausibility-columns = 各列与其名称不符（{ $what }）：字段可能错后一位，或列互换；请以 --columns 指明各列。
plausibility-column-follows = 静止时 { $channel } 如加速度计一样随重力变化
plausibility-column-nothing = { $triad ->
        [gyro] 陀螺对绕 { $axis } 轴的角速率无读数
       *[accel] 加速度计对沿 { $axis } 轴的重力无读数
    }
plausibility-coarse-log = { $sensors ->
        [gyro] 陀螺
       *[accel] 加速度计
    }停留于同一码值 { $count } 次，涉及 { $of } 段中的 { $segments } 段：其步进 { $step } { $sensors ->
        [gyro] rad/s
       *[accel] m/s²
    } 大于噪声；请记录更多位数，或选用较小量程。
plausibility-held-rows = { $listed }：多达 { $share } % 的行重复前一行的{ $sensors ->
        [gyro] 陀螺
       *[accel] 加速度计
    }读数（通常为 { $usual } %）：在该运动下读数被保持，如量程自适应所致；{ $count ->
       *[other] 这些段可疑
    }。
seen-no-data = { $rows } 行中有 { $count } 行以无数据标记（{ $mark }）代替{ $sensors ->
        [gyro] 陀螺
       *[accel] 加速度计
    }读数：已剔除。
seen-copies = { $others } 在全部 { $rows } 行中与 { $first } 相同：同一列被记录多次，且无法判断其为哪一轴；{ $sensors ->
        [gyro] 陀螺
       *[accel] 加速度计
    }读数未被采用。请分别记录各轴。
seen-clock-set = 时钟{ $count ->
        [1] {""}
       *[other] 共 { $count } 次被调整，首次
    }在第 { $line } 行之前被{ $way ->
        [ahead] 拨快
       *[back] 拨慢
    } { $seconds } s，其间无缺行：时钟的跳变已去除。
seen-restarted = 被校对象或其记录器在第 { $line } 行之前重新启动：{ $known ->
        [labels] 由其后的标注可知有 { $seconds } s（± { $within } s）未被记录，其后各行已相应后移
       *[no] 断开多久无从得知，各行视为连续
    }。其前后为两次通电，零偏不相同{ $left ->
        [none] {""}
       *[other] ；未采用：{ $left }
    }。请分别校准，或重新记录。
plausibility-offset-binary = 无输入时{ $sensors ->
        [gyro] 陀螺读数为 { $read } rad/s
       *[accel] 加速度计读数为 { $read } m/s²
    }，为其量程之半：未扣除 { $codes } 个码（偏移二进制）；此处已扣除。
