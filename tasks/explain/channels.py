"""The channels by number: three gyros, then three accelerometers."""

from schemas.recording import ACCEL, GYRO

CHANNELS = GYRO + ACCEL
GYROS, ACCELS = (0, 1, 2), (3, 4, 5)
EVERY = GYROS + ACCELS
TRIADS = (GYROS, ACCELS)
