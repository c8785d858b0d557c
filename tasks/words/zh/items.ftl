## 各规范的校准项目及其元素。$reads：输出轴；$input：输入轴。

item-gyro-scale-factor = 陀螺标度因数
    .element = { $reads } 轴陀螺标度因数
item-gyro-fit-offset = 陀螺拟合零偏
    .element = { $reads } 轴陀螺拟合零偏
item-gyro-bias = 陀螺零偏
    .element = { $reads } 轴陀螺零偏
item-gyro-cross-coupling = 陀螺交叉耦合系数
    .element = { $input } 轴对 { $reads } 轴交叉耦合系数
item-gyro-g-sensitivity = 陀螺加速度敏感系数
    .element = { $input } 轴加速度对 { $reads } 轴陀螺
item-accel-scale-factor = 加速度计标度因数
    .element = { $reads } 轴加速度计标度因数
item-accel-bias = 加速度计偏值
    .element = { $reads } 轴加速度计偏值
item-accel-cross-coupling = 加速度计交叉耦合系数
    .element = { $input } 轴对 { $reads } 轴交叉耦合系数
item-accel-rate-sensitivity = 加速度计角速度灵敏系数
    .element = { $input } 轴角速度对 { $reads } 轴加速度计
item-ahrs-scale-factor = 标度因数
    .element = { $reads } 轴标度因数
item-ahrs-zero-offset = 零偏
    .element = { $reads ->
        [X] 航向角
        [Y] 俯仰角
       *[Z] 横滚角
    }零偏
item-ahrs-misalignment = 失准角
    .element = { $input } 轴对 { $reads } 轴失准角
