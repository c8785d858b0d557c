"""How much of Earth's rotation the rests of a recording show: its gain λ, 1 in full, 0 absent."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from tasks.motion.table import EARTH_RATE
from tasks.motion.whole import unit_vector
from tasks.specifications.linear import birge_ratio, solve
from tasks.words import Message, message
from tasks.words.rounding import MINUS

if TYPE_CHECKING:
    from tasks.specifications.evidence import ClauseEvidence

REFUTED = 3.0  # standard uncertainties from a gain that the data then refute

State = Literal["present", "not_visible", "not_shown", "odd"]


@dataclass(frozen=True)
class EarthRotationGain:
    """The gain λ with its standard uncertainty, and what it rests on.

    level: from the horizontal part, which a g-sensitivity cannot imitate; else from readings up
    minus down, which contain a g-sensitivity too.
    """

    gain: float
    u: float
    level: bool

    @property
    def state(self) -> State:
        """Which of «present» (1) and «absent» (0) the data allow, at three u; odd: neither."""
        present = abs(self.gain - 1.0) <= REFUTED * self.u
        absent = abs(self.gain) <= REFUTED * self.u
        if present:
            return "not_visible" if absent else "present"
        if absent:
            return "not_shown"
        return "odd" if self.level else "not_visible"

    @property
    def refuted(self) -> bool:
        """Whether the data show that Earth's rotation is not in them."""
        return self.level and self.state == "not_shown"


def earth_rotation_message(earth: EarthRotationGain | None) -> Message:
    """What the data show of Earth's rotation, a clause without its full stop."""
    if earth is None:
        return message("earth-rotation-unknown")
    gain = f"λ = {earth.gain:.3f} ± {2.0 * earth.u:.3f}, k = 2".replace("-", MINUS)
    basis = "level" if earth.level else "vertical"
    return message(f"earth-rotation-{basis}-{earth.state.replace('_', '-')}", gain=gain)


def earth_rotation_gain(evidence: "ClauseEvidence") -> EarthRotationGain | None:
    """λ by least squares over the rests; None without a latitude, or where no rest determines it.

    Where north is known in the rests: for each gyro, bias, three g-sensitivities and λ times the
    north component of Earth's rate; the vertical part cannot be separated from the g-sensitivity
    and does not count. Else: (up − down)/2 over ωe·sin φ, as if the g-sensitivity were none. The
    gyros together by their weights; where they disagree u is enlarged. A scale factor of 1 is
    taken.
    """
    rests = [
        i
        for i in evidence.of_kind("static")
        if evidence.segments[i].has_gyro and evidence.up[i] is not None
    ]
    if evidence.latitude_deg is None or not rests:
        return None
    phi = np.radians(evidence.latitude_deg)
    up = np.array([unit_vector(evidence.up[i]) for i in rests])
    north = evidence.north[rests]
    level = bool(np.isfinite(north).all())
    earth = np.cos(phi) * north if level else np.sin(phi) * up
    by_gyro = [_of_gyro(evidence, rests, up, EARTH_RATE * earth, c, level) for c in range(3)]
    gains = np.array([gain for gain in by_gyro if gain is not None])
    if not len(gains):
        return None
    weights = 1.0 / gains[:, 1] ** 2
    mean = float(weights @ gains[:, 0] / weights.sum())
    square = float(weights @ (gains[:, 0] - mean) ** 2) / max(len(gains) - 1, 1)
    return EarthRotationGain(mean, float(np.sqrt(max(square, 1.0) / weights.sum())), level)


def _of_gyro(
    evidence: "ClauseEvidence",
    rests: list[int],
    up: np.ndarray,
    earth: np.ndarray,
    gyro: int,
    level: bool,
) -> tuple[float, float] | None:
    """λ and u of one gyro; None where its rests do not determine it."""
    bias, rate = np.ones(len(rests)), earth[:, gyro]
    columns = (bias, *up.T, rate) if level else (bias, rate)
    if not level:
        rests = [i for i, on in zip(rests, rate, strict=True) if on]
        columns = (bias[rate != 0.0], rate[rate != 0.0])
    design = np.column_stack(columns)
    if not len(design):
        return None
    solution = solve(design)
    readings = evidence.means[rests, gyro]
    covariance = evidence.covariance(gyro)[np.ix_(rests, rests)]
    u = float(solution.uncertainty(covariance)[-1])
    u *= birge_ratio(solution, design, readings, covariance).factor
    value = float(solution.of(readings)[-1])
    return (value, u) if np.isfinite(value) and u > 0.0 else None
