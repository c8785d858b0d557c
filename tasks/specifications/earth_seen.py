"""Whether the rests of a recording show Earth's rotation: its gain λ, 1 as known, 0 absent."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from schemas.recording import Recording
from tasks.motion.table import EARTH_RATE
from tasks.motion.whole import unit_vector, whole_motion
from tasks.specifications.evidence import Evidence
from tasks.specifications.linear import solve
from tasks.specifications.parts import excess_scatter

FAR = 3.0  # standard uncertainties at which a gain is refuted
SAMPLES = 20  # times within a rest at which north is looked up

Said = tuple[str, str]  # English, Chinese
State = Literal["seen", "not_visible", "not_shown", "odd"]


@dataclass(frozen=True)
class EarthSeen:
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
        present = abs(self.gain - 1.0) <= FAR * self.u
        absent = abs(self.gain) <= FAR * self.u
        if present:
            return "not_visible" if absent else "seen"
        if absent:
            return "not_shown"
        return "odd" if self.level else "not_visible"

    @property
    def refuted(self) -> bool:
        """Whether the data show that Earth's rotation is not in them."""
        return self.level and self.state == "not_shown"


def earth_seen(recording: Recording, evidence: Evidence) -> EarthSeen | None:
    """λ by least squares over the rests; None without a latitude or a witness.

    Where north is known in the rests: for each gyro, bias, three g-sensitivities and λ times the
    north component of Earth's rate; the vertical part is not told from the g-sensitivity and has
    no say. Else: (up − down)/2 over ωe·sin φ, as if the g-sensitivity were none. The gyros
    together by their weights; where they disagree u is enlarged. A scale factor of 1 is taken.
    """
    latitude = recording.manifest.station.latitude_deg
    rests = [
        i
        for i, segment in enumerate(evidence.segments)
        if segment.segment.kind == "static" and segment.has_gyro and evidence.up[i] is not None
    ]
    if latitude is None or not rests:
        return None
    phi = np.radians(latitude)
    up = np.array([unit_vector(evidence.up[i]) for i in rests])
    north = _north(recording, evidence, rests)
    level = bool(np.isfinite(north).all())
    earth = np.cos(phi) * north if level else np.sin(phi) * up
    known = [_of_gyro(evidence, rests, up, EARTH_RATE * earth, c, level) for c in range(3)]
    found = np.array([each for each in known if each is not None])
    if not len(found):
        return None
    weights = 1.0 / found[:, 1] ** 2
    gain = float(weights @ found[:, 0] / weights.sum())
    square = float(weights @ (found[:, 0] - gain) ** 2) / max(len(found) - 1, 1)
    return EarthSeen(gain, float(np.sqrt(max(square, 1.0) / weights.sum())), level)


def _north(recording: Recording, evidence: Evidence, rests: list[int]) -> np.ndarray:
    """Mean direction (n, 3) of north in the body in each rest; NaN where it is not known."""
    held = [evidence.segments[i] for i in rests]
    looked = [np.linspace(s.t_start, s.t_end, SAMPLES, endpoint=False) for s in held]
    north = whole_motion(recording, np.concatenate(looked)).north
    return np.asarray(north.reshape(len(rests), SAMPLES, 3).mean(axis=1))


def _of_gyro(
    evidence: Evidence, rests: list[int], up: np.ndarray, earth: np.ndarray, gyro: int, level: bool
) -> tuple[float, float] | None:
    """λ and u of one gyro; None where its rests do not determine it."""
    bias, felt = np.ones(len(rests)), earth[:, gyro]
    columns = (bias, *up.T, felt) if level else (bias, felt)
    if not level:
        rests = [i for i, on in zip(rests, felt, strict=True) if on]
        columns = (bias[felt != 0.0], felt[felt != 0.0])
    design = np.column_stack(columns)
    if not len(design):
        return None
    solution = solve(design)
    readings = evidence.means[rests, gyro]
    covariance = evidence.covariance(gyro)[np.ix_(rests, rests)]
    u = float(solution.uncertainty(covariance)[-1])
    u *= excess_scatter(solution, design, readings, covariance).factor
    value = float(solution.of(readings)[-1])
    return (value, u) if np.isfinite(value) and u > 0.0 else None


UNKNOWN = (
    "The rests do not tell whether Earth's rotation is in the data",
    "静止数据不能说明是否含地球自转",
)
LEVEL: dict[State, Said] = {
    "seen": (
        "Earth's rotation is seen in the rests at different headings ({}; 1: in full, 0: absent)",
        "不同方位的静止数据中可见地球自转（{}；1 为完全存在，0 为不存在）",
    ),
    "not_visible": (
        "Earth's rotation is not visible above the noise ({}; 1: in full, 0: absent)",
        "地球自转未能从噪声中辨出（{}；1 为完全存在，0 为不存在）",
    ),
    "not_shown": (
        "The data do not show Earth's rotation ({}; 1: in full, 0: absent): they are simulated or "
        "compensated already, or latitude or heading are not as told",
        "数据中没有地球自转（{}；1 为完全存在，0 为不存在）：数据为仿真或已补偿，或纬度、方位有误",
    ),
    "odd": (
        "The data show neither the whole of Earth's rotation nor its absence ({}; 1: in full, 0: "
        "absent): check latitude and heading",
        "数据既不符合地球自转完全存在，也不符合其不存在（{}；"
        "1 为完全存在，0 为不存在）：请核对纬度和方位",
    ),
}
UPRIGHT: dict[State, Said] = {
    "seen": (
        "Up minus down the rests read Earth's rotation ({}; 1: in full, 0: absent), if the "
        "unit's own g-sensitivity is small beside it",
        "朝天与朝地之差与地球自转相符（{}；1 为完全存在，0 为不存在），"
        "前提是器件自身的 g 敏感项很小",
    ),
    "not_visible": (
        "Earth's rotation cannot be told from noise and the unit's own g-sensitivity (up minus "
        "down, {}; 1: in full, 0: absent)",
        "地球自转不能与噪声及器件自身的 g 敏感项区分（"
        "朝天与朝地之差，{}；1 为完全存在，0 为不存在）",
    ),
    "not_shown": (
        "The data do not show Earth's rotation (up minus down, {}; 1: in full, 0: absent), unless "
        "a g-sensitivity of the opposite sign hides it",
        "数据中没有地球自转（朝天与朝地之差，{}；1 为完全存在，0 为不存在），"
        "除非被符号相反的 g 敏感项抵消",
    ),
}


def said(seen: EarthSeen | None) -> Said:
    """What the data show of Earth's rotation, in a clause without its full stop."""
    if seen is None:
        return UNKNOWN
    en, zh = (LEVEL if seen.level else UPRIGHT)[seen.state]
    gain = f"λ = {seen.gain:.3f} ± {2.0 * seen.u:.3f}, k = 2".replace("-", "−")
    return en.format(gain), zh.format(gain)
