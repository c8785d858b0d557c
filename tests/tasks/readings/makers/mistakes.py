"""What people do wrong when they record and import, done to a bench's recording."""

from itertools import permutations, product

import numpy as np

from .bench import Bench, G

PROPER = [
    np.eye(3)[list(order)] * np.array(signs)[:, None]
    for order in permutations(range(3))
    for signs in product((1.0, -1.0), repeat=3)
    if np.linalg.det(np.eye(3)[list(order)] * np.array(signs)[:, None]) > 0
][1:]


def gyro_times(made: Bench, factor: float, whole: bool = False) -> None:
    made.gyro = np.rint(made.gyro * factor) if whole else made.gyro * factor


def accel_times(made: Bench, factor: float, whole: bool = False) -> None:
    made.accel = np.rint(made.accel * factor) if whole else made.accel * factor


def gravity_removed(made: Bench) -> None:
    _a, b, c = made.angle.T
    up = np.column_stack([np.sin(b) * np.sin(c), np.sin(b) * np.cos(c), np.cos(b)])
    made.accel = made.accel - G * up


def time_times(made: Bench, factor: float) -> None:
    made.t = made.t * factor
    for label in made.labels:
        label["t_start"] *= factor
        label["t_end"] *= factor


def gyro_mapped(made: Bench, matrix: np.ndarray) -> None:
    made.gyro = made.gyro @ matrix.T


def accel_mapped(made: Bench, matrix: np.ndarray) -> None:
    made.accel = made.accel @ matrix.T


def both_mapped(made: Bench, matrix: np.ndarray) -> None:
    gyro_mapped(made, matrix)
    accel_mapped(made, matrix)


def labels_late(made: Bench, seconds: float) -> None:
    for label in made.labels:
        label["t_start"] += seconds
        label["t_end"] += seconds
