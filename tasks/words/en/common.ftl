## What every room uses.

list-separator = {", "}
clause-sequence = { $first }; { $rest }

channel-gyro_x = gyro x
    .short = gyro x
channel-gyro_y = gyro y
    .short = gyro y
channel-gyro_z = gyro z
    .short = gyro z
channel-accel_x = accelerometer x
    .short = accel. x
channel-accel_y = accelerometer y
    .short = accel. y
channel-accel_z = accelerometer z
    .short = accel. z
triad-gyro = gyros
triad-accel = accelerometers
language-name = English
list = { $entries }
initial = { CAPITAL($text) }
    .lower = { LOWER($text) }
