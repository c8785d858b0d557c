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
plausibility-force-unit = 静止时加速度计读数为 { $read } m/s²，为当地重力加速度（{ $gravity } m/s²）的 { $ratio } 倍：其单位似为 { $unit }；请以 { $option } 导入。
plausibility-rate-unit = 陀螺读数为{ $source ->
        [table] 编码器所示角速率
        [gravity] 各静止段间重力所示转角
       *[labels] 标注角速率
    }的 { $ratio } 倍：其单位似为 { $unit }；请以 { $option } 导入{ $source ->
        [labels] ；若标注有误，则将 rate_deg_s 改为 °/s
       *[other] {""}
    }。
plausibility-table-unit = 编码器转过的角度为陀螺所示的 { $ratio } 倍：其单位似为度；请以 { $option } 导入。
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
