"""The channels by number: three gyros, then three accelerometers."""

GYROS, ACCELS = (0, 1, 2), (3, 4, 5)
EVERY = GYROS + ACCELS
TRIADS = (GYROS, ACCELS)
