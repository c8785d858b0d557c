"""A short run on a three-axis table by plain algebra, and its body's attitude as matrices."""

from functools import cache

import numpy as np

from schemas.recording import Recording, Stream
from tasks.motion.table import TableAxes
from tasks.motion.whole import Motion
from tests.manifests import manifest_of

GRAVITY = 9.8
LATITUDE, HEADING = np.radians(40.0), np.radians(25.0)
DIRECTIONS = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
RATE_HZ, SECONDS = 400.0, 20.0
T = np.arange(0.0, SECONDS, 1.0 / RATE_HZ)
MOUNT = np.array([0.36, 0.48, -0.8])  # rotation vector of the unit on the payload
EAST, NORTH, UP = np.eye(3)


def turns(vectors: np.ndarray) -> np.ndarray:
    """Matrices (n, 3, 3) of rotation vectors (n, 3), by Rodrigues' formula."""
    angle = np.linalg.norm(vectors, axis=-1)[:, None, None]
    x, y, z = np.moveaxis(vectors / np.maximum(angle[:, 0], 1e-300), -1, 0)
    zero = np.zeros_like(x)
    cross = np.moveaxis(np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]), -1, 0)
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def angles() -> np.ndarray:
    """(n, 3) rad: the outer axis goes round twice, the others swing."""
    outer = 8.0 * (1.0 - np.cos(2.0 * np.pi * T / SECONDS))
    return np.column_stack([outer, 0.9 * np.sin(0.7 * T) + 0.4, 1.3 * np.sin(0.5 * T + 1.0)])


ANGLES = angles()
HEADED = turns(np.array([[0.0, 0.0, -HEADING]]))
MOUNTED = turns(MOUNT[None])


def attitude(
    shaft: np.ndarray = ANGLES, between: dict[int, np.ndarray] | None = None
) -> np.ndarray:
    """R_n_body (n, 3, 3) of axes at some angles.

    between: rotation vectors (n, 3) more, in the frame where they happen: −1 in n, before the
    heading; k behind axis k; 3 innermost, in the body.
    """
    more = {place: turns(np.broadcast_to(v, (len(T), 3))) for place, v in (between or {}).items()}
    whole = more.get(-1, np.eye(3)) @ HEADED
    for k, direction in enumerate(DIRECTIONS):
        whole = whole @ turns(shaft[:, k, None] * direction) @ more.get(k, np.eye(3))
    return whole @ MOUNTED @ more.get(3, np.eye(3))


def felt(attitudes: np.ndarray) -> np.ndarray:
    """What a perfect unit reads (n, 6), the rate by the turns between the rows around each."""
    step = np.swapaxes(attitudes[:-2], 1, 2) @ attitudes[2:]
    skew = 0.5 * (step - np.swapaxes(step, 1, 2))
    sine = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)
    size = np.linalg.norm(sine, axis=1)[:, None]
    rate = sine * np.where(size > 0, np.arcsin(size) / np.maximum(size, 1e-300), 1.0)
    padded = np.full((len(T), 3), np.nan)
    padded[1:-1] = 0.5 * RATE_HZ * rate
    return np.hstack([padded, GRAVITY * attitudes[:, 2]])


@cache
def undisturbed() -> np.ndarray:
    """What a perfect unit reads (n, 6) where the axes stand as the encoders say."""
    readings = felt(attitude())
    readings.setflags(write=False)
    return readings


def _slope(series: np.ndarray) -> np.ndarray:
    return np.gradient(series, T, axis=0, edge_order=2)


@cache
def motion() -> Motion:
    """What the encoders tell of the run, in the body frame."""
    inner = np.swapaxes(MOUNTED, 1, 2)
    spins: list[np.ndarray] = []
    for k in (2, 1, 0):
        spins.insert(0, np.broadcast_to(inner @ DIRECTIONS[k], (len(T), 3)))
        inner = inner @ turns(-ANGLES[:, k, None] * DIRECTIONS[k])
    directions, speeds = np.stack(spins, axis=1), _speeds()
    rate = np.einsum("nk,nki->ni", speeds, directions)
    whole = attitude()
    axes = TableAxes(ANGLES, speeds, directions, np.ascontiguousarray(inner @ NORTH))
    recorded = {
        "temperature": 22.0 + 0.2 * T, "temperature_rate": 1e-3 * T,
        "supply_voltage": 5.0 + 0.05 * np.sin(T), "vibration": 0.3 + 0.1 * np.cos(T),
        "fixing": np.floor(T / 7.0),
    }  # fmt: skip
    up, north = whole[:, 2].copy(), whole[:, 1].copy()
    return Motion(T, up, north, rate, _slope(rate), GRAVITY, axes, recorded)


def _speeds() -> np.ndarray:
    outer = 16.0 * np.pi / SECONDS * np.sin(2.0 * np.pi * T / SECONDS)
    return np.column_stack([outer, 0.63 * np.cos(0.7 * T), 0.65 * np.cos(0.5 * T + 1.0)])


def recording(latitude: float | None = 40.0) -> Recording:
    """A recording whose manifest tells the site; its streams are of no interest."""
    manifest = manifest_of("table run", {"latitude_deg": latitude, "gravity_m_s2": GRAVITY})
    return Recording(manifest, Stream(T, {}))


def read(terms: tuple, values: np.ndarray | list[float], run: Motion | None = None) -> np.ndarray:
    """Readings (n, 6) of an otherwise ideal unit with some terms."""
    from tasks.model.model import predict
    from tasks.model.term import nominal_values
    from tasks.model.terms.standard import STANDARD_TERMS

    ideal = nominal_values(STANDARD_TERMS)
    return predict((*terms, *STANDARD_TERMS), run or motion(), np.concatenate([values, ideal]))
