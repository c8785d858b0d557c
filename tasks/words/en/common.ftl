## What every room uses.

list-separator = {", "}
clause-sequence = { $first }; { $rest }

channel-gyro_x = gyro x
channel-gyro_y = gyro y
channel-gyro_z = gyro z
channel-accel_x = accelerometer x
channel-accel_y = accelerometer y
channel-accel_z = accelerometer z
triad-gyro = gyros
triad-accel = accelerometers
language-name = English
list = { $entries }
