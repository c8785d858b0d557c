"""A unit of models (1) and (2) of JJF 2003-2022, drawn from a seed."""

from dataclasses import asdict, dataclass

import numpy as np

from tests.proof.plant.seeds import generator


@dataclass(frozen=True)
class UnitErrors:
    """gyro = Kg·ω + Bg + G·f, accel = Ka·f + Ba + P·ω²; SI, the first index reads."""

    Kg: np.ndarray
    Bg: np.ndarray
    G: np.ndarray
    Ka: np.ndarray
    Ba: np.ndarray
    P: np.ndarray

    def parameters(self) -> dict[str, list[float] | list[list[float]]]:
        """All of them as plain lists."""
        return {name: value.tolist() for name, value in asdict(self).items()}

    def reads(self, rates: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Readings (6, n) at rates (3, n) rad/s and specific force (3, n) m/s²."""
        gyro = self.Kg @ rates + self.Bg[:, None] + self.G @ force
        accel = self.Ka @ force + self.Ba[:, None] + self.P @ rates**2
        return np.concatenate([gyro, accel])


def draw_unit(seed: int) -> UnitErrors:
    """Scale 0.5 %, cross coupling 0.2 %, biases 0.2 °/s and 4 mg, small g- and ω²-sensitivity."""
    rng = generator(seed, "unit")
    off = 1.0 - np.eye(3)

    def matrix(diagonal: float, beside: float) -> np.ndarray:
        drawn = rng.standard_normal((3, 3))
        return np.asarray(drawn * (diagonal * np.eye(3) + beside * off))

    return UnitErrors(
        Kg=np.eye(3) + matrix(5e-3, 2e-3),
        Bg=3.5e-3 * rng.standard_normal(3),
        G=matrix(1.5e-5, 1.5e-5),
        Ka=np.eye(3) + matrix(5e-3, 2e-3),
        Ba=0.04 * rng.standard_normal(3),
        P=matrix(0.0, 4e-4),
    )
