"""The table's drive and encoders: ripple, eccentricity, scale."""

from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import Recording
from tasks.model.term import Parameter, Term, single
from tasks.motion.whole import Motion, with_small_rotation

MAX_PER_TURN = 24
AXIS = Parameter("axis", "k", "1", "1", (1.0, 9.0))  # table axis from outside, from 1


@dataclass(frozen=True)
class RateRipple(Term):
    """The shaft runs ahead and behind N times a turn, between what the encoder can follow.

    shapes: N, and the table axis from 1. Depth of the rate's ripple: √(s² + c²).
    """

    def moved(self, motion: Motion, values: np.ndarray) -> Motion:
        per_turn, axis = self.at
        return _off_encoder(motion, int(axis) - 1, per_turn, values / per_turn)


@dataclass(frozen=True)
class EncoderEccentricity(Term):
    """The encoder errs once a turn: the shaft is where it says, minus the error."""

    def moved(self, motion: Motion, values: np.ndarray) -> Motion:
        return _off_encoder(motion, int(self.at[0]) - 1, 1.0, -values)


def _off_encoder(motion: Motion, axis: int, per_turn: float, amplitudes: np.ndarray) -> Motion:
    """A shaft at θ + s·sin Nθ + c·cos Nθ; amplitudes: s, c in rad."""
    axes = motion.axes
    if axes is None:
        return motion
    s, c = amplitudes
    angle = per_turn * axes.angles[:, axis]
    sin, cos = np.sin(angle), np.cos(angle)
    change = (s * cos - c * sin) * per_turn * axes.speeds[:, axis]
    direction = axes.directions[:, axis]
    return with_small_rotation(motion, direction, s * sin + c * cos, change, axes.outside(axis))


def rate_ripple(per_turn: int, axis: int) -> RateRipple:
    """A ripple N times a turn of a table axis, counted from 1."""
    return RateRipple(
        "rate_ripple", "table", "motion", "θ̇ = θ̇₀·(1 + s·cos Nθ − c·sin Nθ)", "IEEE Std 1554",
        single("depth_sin", "s", ("1", "1", 0.02)) + single("depth_cos", "c", ("1", "1", 0.02)),
        (Parameter("per_turn", "N", "1", "1", (2.0, float(MAX_PER_TURN))), AXIS),
        (float(per_turn), float(axis)),
        confused_with=("encoder_eccentricity", "axis_wobble", "mains_pickup"),
    )  # fmt: skip


def encoder_eccentricity(axis: int) -> EncoderEccentricity:
    """An encoder error once a turn of a table axis, counted from 1."""
    return EncoderEccentricity(
        "encoder_eccentricity", "table", "motion", "θ = θ_enc − (s·sin θ + c·cos θ)",
        "IEEE Std 1554",
        single("amplitude_sin", "s", ("arcsec", "rad", 0.01))
        + single("amplitude_cos", "c", ("arcsec", "rad", 0.01)),
        (AXIS,), (float(axis),),
        confused_with=("axis_wobble", "rate_ripple"),
    )  # fmt: skip


@dataclass(frozen=True)
class TableScale(Term):
    """Every encoder says (1 + scale) of what its shaft turned; exact, for angles of many turns."""

    def moved(self, motion: Motion, values: np.ndarray) -> Motion:
        axes = motion.axes
        if axes is None:
            return motion
        share = -values[0] / (1.0 + values[0])
        up, north, base = motion.up, motion.north, axes.base
        rate, by_encoders = np.zeros_like(motion.rate), np.zeros_like(motion.rate)
        for k in range(axes.angles.shape[1]):
            direction, more = axes.directions[:, k], share * axes.angles[:, k]
            up, north, base, rate = (_seen(v, direction, more) for v in (up, north, base, rate))
            rate += ((1.0 + share) * axes.speeds[:, k])[:, None] * direction
            by_encoders += axes.speeds[:, k, None] * direction
        # Only the difference counts: means over a block of time are no product of means.
        rate += motion.rate - by_encoders
        # What turned was a little more or less fast, and so were its ramps.
        slower = (1.0 + share) * motion.acceleration
        return replace(
            motion, up=up, north=north, rate=rate, acceleration=slower,
            axes=replace(axes, base=base),
        )  # fmt: skip


def _seen(vector: np.ndarray, direction: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) seen from what turned by angles (n,) about directions (n, 3) (Rodrigues)."""
    along = (vector * direction).sum(axis=1)[:, None] * direction
    sin, cos = np.sin(angle)[:, None], np.cos(angle)[:, None]
    return along + cos * (vector - along) - sin * np.cross(direction, vector)


TABLE_SCALE = TableScale(
    "table_scale", "table", "motion", "θ = θ_enc/(1 + κ) on every axis", "IEEE Std 1554",
    single("scale", "κ", ("1", "1", 0.1)),
    confused_with=("clock_skew", "temperature_scale"),
)  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """Nothing without the table's axes; ripple of each axis that turned more than once round."""
    axes = motion.axes
    if axes is None:
        return ()
    spans = [_span(signal) for signal in axes.angles.T]
    whole = tuple(k for k, span in enumerate(spans, start=1) if k == 1 or span > 2.0 * np.pi)
    ripples = (rate_ripple(n, axis) for axis in whole for n in range(2, MAX_PER_TURN + 1))
    return (*ripples, *(encoder_eccentricity(axis) for axis in whole), TABLE_SCALE)


def _span(signal: np.ndarray) -> float:
    known = signal[np.isfinite(signal)]
    return float(np.ptp(known)) if len(known) else 0.0
