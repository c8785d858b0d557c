## 联合法：缺项原因，以及阅读结果须知。

joint-of-elements = { $elements }：{ $reason }
joint-not-distinguished = 本次各段数据不足以将其与其他参数区分
joint-not-turned-gyro = 绕 { $axes } 轴转动且记录了陀螺数据的已知角速率段少于两个
joint-not-turned-accel = 绕 { $axes } 轴转动且记录了加速度计数据的已知角速率段缺失
joint-no-rest-gyro = 缺少 { $ups } 朝天且记录了陀螺数据的静止位置
joint-no-rest-accel = 缺少 { $ups } 朝天且记录了加速度计数据的静止位置
joint-horizontal-unknown = 非对角元：{ $ups } 仅在一个方位测量且北向未知，地球自转水平分量未知

joint-number-of-rates = 角速率点少于 { $fewest } 个：{ $rates }；联合法要求各轴正、反转各不少于 { $fewest } 个角速率点，并包括最大角速率。
joint-orientations-not-turned = 未在 { $ups } 朝天时转动；专利权利要求 3 为六个方向均转动。
joint-rates-not-rising = { $axes } 轴：角速率未按权利要求 4 由小到大的顺序。

joint-earth-not-removed = 未给出纬度：未扣除地球自转，g 敏感系数对角元含其竖直分量。
joint-earth-not-shown = { $shown }。未予扣除：偏值与 g 敏感系数即为数据所示。
joint-earth-removed = { $shown }。已按纬度 { $latitude }° 作为已知输入扣除：偏值与 g 敏感系数均为扣除后的值。
joint-north-unknown = 静止位置的北向未知：仅扣除地球自转的竖直分量；水平分量在相差 180° 的两个方位间抵消，否则留在偏值中。
joint-scatter = 各段与模型的偏差超过噪声（{ $channels } 倍），不确定度已按此放大。

## 仅以重力为参考的联合法：手持静止与运动。

joint-gravity-alone = 无转台数据和分段标注：仅以重力为参考，静止段由数据自动识别。
joint-gravity-residual = { $rests } 个静止位置的比力与重力之差为 { $rms } m/s²（均方根），未超过噪声。
joint-gravity-residual-excess = { $rests } 个静止位置的比力与重力之差为 { $rms } m/s²（均方根），为噪声的 { $factor } 倍，不确定度已按此放大。
joint-moves-residual = { $moves } 次运动中，陀螺积分与竖直方向之差为 { $angle }°（均方根），陀螺的不确定度由该离散性得到。
joint-vertical-removed = 仅扣除地球自转的竖直分量：静止位置的北向未知。
joint-no-moves = 没有九次以上、绕各轴转动且记录了两组数据的静止位置间运动
joint-coupling-by-definition = 按定义为零，以加速度计敏感轴为基准
joint-no-rate-held = 没有已知的恒定角速率
joint-few-rests = 有加速度计数据的静止位置 { $rests } 个；需 { $fewest } 个以上、姿态遍布各方向
