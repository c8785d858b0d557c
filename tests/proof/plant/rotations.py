"""Attitudes as quaternions (w, x, y, z) in arrays (4, n); (4, 1) is constant."""

import numpy as np


def about(axis: np.ndarray, angle: np.ndarray | float) -> np.ndarray:
    """Rotation about a unit axis (3,) by an angle in rad: (4, n)."""
    half = np.atleast_1d(np.asarray(angle, dtype=float)) / 2.0
    sine = np.sin(half)
    return np.stack([np.cos(half), axis[0] * sine, axis[1] * sine, axis[2] * sine])


def from_vector(vector: np.ndarray) -> np.ndarray:
    """Rotation vectors (3, n) or (3,), in rad, as quaternions (4, n)."""
    columns = vector.reshape(3, -1)
    angle = np.sqrt((columns**2).sum(axis=0))
    share = np.sinc(angle / (2.0 * np.pi)) / 2.0
    return np.concatenate([np.cos(angle / 2.0)[None], columns * share])


def product(first: np.ndarray, then: np.ndarray) -> np.ndarray:
    """first · then: the frame of `then` is carried by `first`."""
    a, b, c, d = first
    w, x, y, z = then
    return np.stack([
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ])  # fmt: skip


def inverse(q: np.ndarray) -> np.ndarray:
    """The opposite rotation."""
    return q * np.array([[1.0], [-1.0], [-1.0], [-1.0]])


def turned(q: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """A vector (3,) or (3, n) of the carried frame, seen from outside: (3, n)."""
    v = vector.reshape(3, -1)
    u = q[1:]
    twice = 2.0 * np.stack([
        u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0],
    ])  # fmt: skip
    cross = np.stack([
        u[1] * twice[2] - u[2] * twice[1],
        u[2] * twice[0] - u[0] * twice[2],
        u[0] * twice[1] - u[1] * twice[0],
    ])  # fmt: skip
    return v + q[0] * twice + cross


def vector_of(q: np.ndarray) -> np.ndarray:
    """The rotation vectors (3, n), in rad, of rotations by less than half a turn."""
    length = np.sqrt((q[1:] ** 2).sum(axis=0))
    half = np.arctan2(length, q[0])
    share = np.where(length > 1e-12, 2.0 * half / np.where(length > 1e-12, length, 1.0), 2.0)
    return q[1:] * share


def rates(q: np.ndarray, step: float) -> np.ndarray:
    """Angular rates (3, n − 4), rad/s, in the carried frame, at all but two points at each end.

    From the turns between the neighbours one and two points away on both sides, combined so that
    what is left of the error goes with the fourth power of `step`, the time in s between points.
    """
    near = vector_of(product(inverse(q[:, 1:-3]), q[:, 3:-1]))
    far = vector_of(product(inverse(q[:, :-4]), q[:, 4:]))
    return (8.0 * near - far) / (12.0 * step)


def slope(series: np.ndarray, step: float) -> np.ndarray:
    """The derivative of courses (…, n) that rest at both ends, to the same order as `rates`."""
    changed = np.zeros_like(series)
    near = series[..., 3:-1] - series[..., 1:-3]
    changed[..., 2:-2] = (8.0 * near - (series[..., 4:] - series[..., :-4])) / (12.0 * step)
    return changed
