## 各规范共用：数据中的地球自转、缺项原因、不确定度。

specifications-no-gravity = 未给出当地重力加速度
specifications-rates-needed =
    绕 { $axis } 轴{ $count ->
        [0] 没有恒定角速率
       *[other] 仅 { $count } 个恒定角速率
    }，至少需 2 个
specifications-number-of-rates = { $axis } 轴：{ $count } 个角速率点（{ $rates } °/s）；{ $clause } 要求 { $fewest }~{ $most } 个。
specifications-one-direction = { $axis } 轴：所有角速率同号，缺少另一方向。
specifications-of-axis = { $axis }：{ $reason }

specifications-mounting-unknown = 委托要求测得值以安装基面的轴线为准，但不确定度未计入被校对象基面在夹具中的倾斜（极限 mounting，须由实验室给出）。
specifications-unstated = 凡测得值所依赖的最大误差无人给出者，不给出 U，u_A 仅为重复性：{ $items }。请给出转台保持指令速率的误差极限（清单中的 table_time.commanded_rate、导入时的 --commanded-rate，或实验室的 rate 极限）及其角度的极限。
    .item = { $item } { $elements }（u_A ≤ { $u } { $unit }）
specifications-drift-in-run = 测量期间零位有平缓漂移，首尾相差 { $channels }（{ $unit }）：测得值为本次通电期间的平均，其预算已计入该漂移对全程平均的影响。
specifications-temperature = 各测得值对应的被校对象温度（自身传感器）均为 { $at } ℃。
specifications-temperatures = 各测得值对应的被校对象温度（自身传感器），℃：{ $items }。
    .item = { $item } { $at }
specifications-equipment-unknown = 记录未说明所依据的规范，实验室也未给出转台允许误差：转台和夹具未知的不确定度分量未计入，不确定度含数据分散性、分辨力、当地重力和纬度的分量。

earth-rotation-unknown = 静止数据不能说明是否含地球自转
earth-rotation-level-present = 不同方位的静止数据中可见地球自转
earth-rotation-level-not-visible = 地球自转未能从噪声中辨出
earth-rotation-level-not-shown = 数据中没有地球自转：数据为仿真或已补偿，或纬度、方位有误
earth-rotation-level-odd = 数据既不符合地球自转完全存在，也不符合其不存在：请核对纬度和方位
earth-rotation-vertical-present = 朝天与朝地之差与地球自转相符，前提是被校对象自身的 g 敏感项很小
earth-rotation-vertical-not-visible = 地球自转不能与噪声及被校对象自身的 g 敏感项区分（朝天与朝地之差）
earth-rotation-vertical-not-shown = 数据中没有地球自转（朝天与朝地之差），除非被符号相反的 g 敏感项抵消
earth-rotation-scale-factor-assumed = 本次未得陀螺标度因数处，扣除地球自转时取 1。
specifications-stand-labelled = 未记录编码器：评定不确定度时，各段转台轴的位置按标注取用。
specifications-stand-unknown = 既未记录编码器，也未说明转台各轴：评定不确定度时，各面及各次定位的偏角视为相互独立。
