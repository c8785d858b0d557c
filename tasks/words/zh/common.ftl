## 各处共用。

list-separator = 、
clause-sequence = { $first }；{ $rest }

channel-gyro_x = 陀螺 x
    .short = 陀螺 x
channel-gyro_y = 陀螺 y
    .short = 陀螺 y
channel-gyro_z = 陀螺 z
    .short = 陀螺 z
channel-accel_x = 加速度计 x
    .short = 加速度计 x
channel-accel_y = 加速度计 y
    .short = 加速度计 y
channel-accel_z = 加速度计 z
    .short = 加速度计 z
triad-gyro = 陀螺
triad-accel = 加速度计
language-name = 中文
list = { $entries }
initial = { CAPITAL($text) }
    .lower = { LOWER($text) }
