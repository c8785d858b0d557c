"""A short run of rests and moves by plain algebra, observed in blocks, for the engine's tests."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.fft import dct

from schemas.recording import Segment
from tasks.explain.inputs.blocks import Blocks
from tasks.explain.noise import Noise
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.design import BandedDesign, NormalEquations
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.stepwise import Selected, Selection
from tasks.model.model import predict
from tasks.model.term import Column, Term, nominal_values
from tasks.model.terms.standard import STANDARD_TERMS, regressors
from tasks.motion.whole import Motion

GRAVITY = 9.8
REST, MOVE, SPANS = 12.0, 8.0, 20  # s, s
RATE = 25.0  # Hz
WHITE = np.repeat([2e-5, 5e-4], 3)  # standard deviation of a block, rad/s and m/s²
QUIET = tuple(Noise(sigma**2, 0.0) for sigma in WHITE)
NOISY = tuple(Noise(sigma**2, 0.05 * sigma**2) for sigma in WHITE)


def motion(rate: float = RATE) -> Motion:
    """Twenty rests of 12 s; between them 8 s about one axis after another, there and back.

    The angle within a move is a raised cosine's integral, so that rate and acceleration are smooth.
    """
    t = np.arange(0.0, SPANS * (REST + MOVE), 1.0 / rate)
    part = np.clip((t % (REST + MOVE) - REST) / MOVE, 0.0, 1.0)
    number = (t // (REST + MOVE)).astype(int)
    up, north = np.zeros((len(t), 3)), np.zeros((len(t), 3))
    speed, change = np.zeros((len(t), 3)), np.zeros((len(t), 3))
    now = np.eye(3)  # rows: east, north, up in the body
    for k in range(SPANS):
        rows, axis = number == k, np.eye(3)[k % 3]
        whole = (-1.0) ** (k // 3) * np.radians(450.0 + 40.0 * (k % 4))
        angle = whole * (part[rows] - np.sin(2.0 * np.pi * part[rows]) / (2.0 * np.pi))
        north[rows], up[rows] = (_turned(now[i], axis, -angle) for i in (1, 2))
        turns = whole / MOVE
        speed[rows] = (turns * (1.0 - np.cos(2.0 * np.pi * part[rows])))[:, None] * axis
        bend = turns * 2.0 * np.pi / MOVE * np.sin(2.0 * np.pi * part[rows])
        change[rows] = bend[:, None] * axis
        now = np.array([_turned(row, axis, np.array([-whole]))[0] for row in now])
    slow = 2.0 * np.pi / 170.0  # rad/s: the room's heating
    recorded = {
        "temperature": 28.0 - 6.0 * np.exp(-t / 150.0) + 1.5 * np.sin(slow * t),
        "temperature_rate": 0.04 * np.exp(-t / 150.0) + 1.5 * slow * np.cos(slow * t),
        "fixing": np.zeros(len(t)), "steady_turn": np.zeros(len(t)),
    }  # fmt: skip
    return Motion(t, up, north, speed, change, GRAVITY, recorded=recorded)


def _turned(vector: np.ndarray, axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """(n, 3) a vector turned by angles (n,) about an axis, by Rodrigues' formula."""
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along = axis * (axis @ vector)
    return along + cos * (vector - along) + sin * np.cross(axis, vector)


def segments() -> tuple[Segment, ...]:
    """A rest and a move in turn."""
    found = []
    for k in range(SPANS):
        start = k * (REST + MOVE)
        found.append(Segment(name=f"rest_{k}", kind="static", t_start=start, t_end=start + REST))
        found.append(
            Segment(
                name=f"move_{k}", kind="transition", t_start=start + REST,
                t_end=start + REST + MOVE,
            )
        )  # fmt: skip
    return tuple(found)


def read(run: Motion, *terms: tuple[Term, Sequence[float] | np.ndarray]) -> np.ndarray:
    """Readings (n, 6), without noise, of an otherwise ideal unit with some terms."""
    values = [nominal_values(STANDARD_TERMS), *(np.array(own, float) for _, own in terms)]
    everything = (*STANDARD_TERMS, *(term for term, _ in terms))
    return predict(everything, run, np.concatenate(values))


def noise(count: int, seed: int, noises: Sequence[Noise] = QUIET, rate: float = RATE) -> np.ndarray:
    """(n, 6) white and flicker noise of blocks, such that a coefficient has variance w + b/f."""
    rng = np.random.default_rng(seed)
    return np.column_stack([
        np.sqrt(one.white) * rng.standard_normal(count)
        + flicker(count, rate, one.flicker, rng)
        for one in noises
    ])  # fmt: skip


def flicker(count: int, rate: float, b: float, rng: np.random.Generator) -> np.ndarray:
    """(count,) noise of variance b/f in an orthonormal transform: white noise, shaped."""
    if not b:
        return np.zeros(count)
    size = 16 * count
    f = np.fft.rfftfreq(size, 1.0 / rate)
    shape = np.zeros(len(f))
    shape[1:] = np.sqrt(b / f[1:])
    return np.fft.irfft(np.fft.rfft(rng.standard_normal(size)) * shape, size)[:count]


def observed(readings: np.ndarray, run: Motion, rate: float = RATE) -> Blocks:
    """Blocks as they stand, all of full weight."""
    at = (run.t // (REST + MOVE)).astype(int)
    segment = 2 * at + (run.t % (REST + MOVE) >= REST)
    return Blocks(
        run.t, readings, np.ones((len(run.t), 6)), run, rate, segment, segments(), np.zeros(6)
    )


def whitened(
    courses: Sequence[np.ndarray], pool: BandedDesign, channel: int, of: Noise
) -> np.ndarray:
    """(n, k) courses of one channel, weighed, padded, transformed and divided by the noise."""
    length = int(pool.bands.edges[-1])
    stack = np.zeros((length, len(courses)))
    for k, series in enumerate(courses):
        stack[: len(series), k] = series * pool.blocks.weight[:, channel]
    level = np.repeat(of.variance(pool.bands.frequency), pool.bands.sizes)
    return np.asarray(dct(stack, type=2, norm="ortho", axis=0)) / np.sqrt(level)[:, None]


def chi2(
    pool: BandedDesign,
    readings: np.ndarray,
    columns: Sequence[Column],
    noises: Sequence[Noise],
) -> tuple[float, np.ndarray]:
    """Chi-squared of one fit beside the standard's model, and the columns' values (p,).

    Channels stand below each other; a column of several channels has one value.
    """
    blocks, targets = [], []
    base = [regressors(pool.blocks.motion, channel).T for channel in range(6)]
    wide = sum(len(own) for own in base)
    first = 0
    for channel in range(6):
        own = whitened(base[channel], pool, channel, noises[channel])
        block = np.zeros((len(own), wide + len(columns)))
        block[:, first : first + own.shape[1]] = own
        first += own.shape[1]
        for p, column in enumerate(columns):
            if channel in column:
                series = whitened([column[channel]], pool, channel, noises[channel])
                block[:, wide + p] = series[:, 0]
        blocks.append(block)
        targets.append(whitened([readings[:, channel]], pool, channel, noises[channel])[:, 0])
    design, target = np.vstack(blocks), np.concatenate(targets)
    size = np.linalg.norm(design, axis=0)
    size[size == 0] = 1.0
    values, *_ = np.linalg.lstsq(design / size, target, rcond=1e-12)
    left = target - (design / size) @ values
    return float(left @ left), (values / size)[wide:]


def with_weight(one: Blocks, weight: Mapping[int, np.ndarray]) -> Blocks:
    """The same with other weights in some channels."""
    changed = one.weight.copy()
    for channel, series in weight.items():
        changed[:, channel] = series
    return replace(one, weight=changed)


def selected(made: np.ndarray, *terms: Term) -> FittedSelection:
    """Readings (n, 6) of that run fitted by some terms, as if a search had selected them."""
    chosen = tuple(
        Selected(
            Candidate(term, (*range(len(term.parameters)),), (*range(len(term.parameters)),), 1),
            100.0, 90.0, (),
        )
        for term in terms
    )  # fmt: skip
    nothing = NormalEquations(np.zeros((0, 0)), np.zeros(0), np.zeros(0), 0.0)
    selection = Selection(chosen, NOISY, 0.0, nothing)
    return FittedSelection.of(selection, observed(made, motion()), RATE)
