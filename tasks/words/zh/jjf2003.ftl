## JJF 2003-2022 各条款：缺项原因及不符合条款之处。

jjf2003-triad-gyro = 陀螺
jjf2003-triad-accel = 加速度计
jjf2003-triad-gyro-and-accel = 陀螺和加速度计

jjf2003-positions-missing = { $triads }缺少 { $ups } 朝天的可用静止位置；7.2.2.1 要求六个方向齐全。
jjf2003-one-heading = { $ups } 朝天：{ $triads }未按 7.2.2.1 在相差 180° 的两个方位测量，地球自转及转台倾斜的水平分量未抵消。
jjf2003-no-rest-gyro = 没有陀螺数据可用且有轴朝天或朝地的静止位置
jjf2003-no-rest-accel = 没有加速度计数据可用且有轴朝天或朝地的静止位置
jjf2003-position-missing = { $elements }：缺少 { $ups } 朝天的静止位置
jjf2003-positions-scatter = 各位置与模型的偏差超过噪声（{ $channels } 倍），不确定度已按此放大。

jjf2003-latitude-unknown = 扣除地球自转的值：未给出纬度
jjf2003-horizontal-unknown = 扣除地球自转的非对角元：{ $ups } 仅在一个方位测量，水平分量未知
jjf2003-earth-rotation-present = { $shown }。按式(7)，g 敏感系数对角元含地球自转 { $rate } (°/s)/g（纬度 { $latitude }°）；旁列扣除后的值。
jjf2003-earth-rotation-not-visible = { $shown }。静止于地球上的被校对象，按式(7)对角元应含 { $rate } (°/s)/g（纬度 { $latitude }°）；旁列扣除后的值。
jjf2003-earth-rotation-not-shown = { $shown }。“扣除地球自转的值”仍从对角元扣除 { $rate } (°/s)/g（纬度 { $latitude }°），即按随地球转动的装置处理。对仿真或已补偿的数据不得使用，否则重复扣除；此时应使用式(7)的值。
jjf2003-earth-rotation-odd = { $shown }。静止于地球上的被校对象，按式(7)对角元应含 { $rate } (°/s)/g（纬度 { $latitude }°）；旁列扣除后的值。

jjf2003-no-line = { $axes }：式(4)要求绕该轴至少两个恒定角速率
jjf2003-line-scatter = 绕 { $axis } 轴转动时，各点对式(4)直线的离散超过噪声（{ $channels } 倍），不确定度已按此放大。
jjf2003-turned-angle = 标度因数由已知转角得到，而非 7.2.1 的恒定角速率法。

jjf2003-no-rate = 没有绕 { $axis } 轴、且记录了加速度计数据的可用角速率点
jjf2003-not-vertical = 转动时重力不沿 { $axis } 轴，或记录未说明
jjf2003-no-rest-beside = 缺少 { $axis } 轴朝天或朝地的静止数据
jjf2003-p-one-direction = { $axis } 轴：p 仅由一个转动方向得到，随方向变号的影响未抵消。
jjf2003-p-no-rest-after = { $axis } 轴：p 缺少转动后的静止数据，加速度计漂移未抵消。
jjf2003-p-no-rest-before = { $axis } 轴：p 缺少转动前的静止数据，加速度计漂移未抵消。

## 证书结果的各节。

section-scale-factors = 标度因数
section-biases = 零偏
section-gyro-cross-coupling = 陀螺交叉耦合系数
section-accel-cross-coupling = 加速度计交叉耦合系数
section-gyro-g-sensitivity = 陀螺加速度敏感系数 (g)
section-accel-rate-sensitivity = 加速度计角速度灵敏系数 (p)
