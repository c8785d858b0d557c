"""Parameters for each axis, pair of axes or channel, and the columns they multiply.

First index: the axis that reads.
"""

import numpy as np

from schemas.recording import ACCEL, AXES, GYRO
from tasks.model.term import Column, Parameter
from tasks.motion.whole import STANDARD_GRAVITY, Motion

DEG = float(np.degrees(1.0))
MATRIX = tuple((i, j) for i in range(3) for j in range(3))
OFF_DIAGONAL = tuple((i, j) for i, j in MATRIX if i != j)
GYRO_FIRST, ACCEL_FIRST = 0, 3  # channels of the x axes
G = STANDARD_GRAVITY  # m/s², to print per g
STILL = 1e-3  # rad/s: a slower axis stands still
Printed = tuple[str, str, float]  # unit, the SI unit of it, largest plausible in that


def each_axis(name: str, symbol: str, printed: Printed) -> tuple[Parameter, ...]:
    """name_x, name_y, name_z."""
    return tuple(_symmetric(f"{name}_{a}", f"{symbol}_{a}", printed) for a in AXES)


def each_pair(
    letter: str, printed: Printed, pairs: tuple[tuple[int, int], ...] = MATRIX
) -> tuple[Parameter, ...]:
    """letter_xx, letter_xy …: the reading axis, then the one that it follows."""
    names = (f"{letter}_{AXES[i]}{AXES[j]}" for i, j in pairs)
    return tuple(_symmetric(name, name, printed) for name in names)


def each_channel(letter: str, gyro: Printed, accel: Printed) -> tuple[Parameter, ...]:
    """gyro_x … accel_z."""
    return each_gyro(letter, gyro) + tuple(
        _symmetric(name, f"{letter}_a{name[-1]}", accel) for name in ACCEL
    )


def each_gyro(letter: str, printed: Printed) -> tuple[Parameter, ...]:
    """gyro_x, gyro_y, gyro_z."""
    return tuple(_symmetric(name, f"{letter}_g{name[-1]}", printed) for name in GYRO)


def single(name: str, symbol: str, printed: Printed) -> tuple[Parameter, ...]:
    """A single parameter that is as likely negative as positive."""
    return (_symmetric(name, symbol, printed),)


def own(first: int, basis: np.ndarray) -> tuple[Column, ...]:
    """Each axis of the triad that starts at channel `first` reads its own column of (n, 3)."""
    return tuple({first + i: basis[:, i]} for i in range(3))


def crossed(
    first: int, basis: np.ndarray, pairs: tuple[tuple[int, int], ...] = MATRIX
) -> tuple[Column, ...]:
    """Each axis reads every column of (n, 3), in the order of `each_pair`."""
    return tuple({first + i: basis[:, j]} for i, j in pairs)


def same(signal: np.ndarray, channels: tuple[int, ...] = tuple(range(6))) -> tuple[Column, ...]:
    """Each channel reads the same signal (n,)."""
    return tuple({channel: signal} for channel in channels)


def triads(rate: np.ndarray, force: np.ndarray) -> tuple[Column, ...]:
    """Gyros read their column of the first (n, 3), accelerometers theirs of the second."""
    return own(GYRO_FIRST, rate) + own(ACCEL_FIRST, force)


def turned(motion: Motion) -> bool:
    """Whether the unit is known to have turned at all."""
    return bool((np.abs(np.nan_to_num(motion.rate)) > STILL).any())


def _symmetric(name: str, symbol: str, printed: Printed) -> Parameter:
    unit, si, largest = printed
    return Parameter(name, symbol, unit, si, (-largest, largest))
