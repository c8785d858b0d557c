"""How a unit's temperature follows the air of a chamber that is set, as far as can be expected."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from schemas.limits import ChamberLimits
from schemas.recording import Recording

MINUTE_S = 60.0
CELL_S = 5.0  # of a thermometer's means
LAGS = np.geomspace(30.0, 1500.0, 40)  # s, that are tried
USUAL_LAG = 300.0  # s, of a unit of which no warm-up tells it
TOLD = 1.0  # K: a warm-up by less tells no time constant

SetPoint = tuple[float, float]  # s, °C


@dataclass(frozen=True)
class ThermalResponse:
    """usual_degc: of the unit, and air_degc of the room, before anything is set. lag_s: time
    constant by which the unit follows the air.
    """

    usual_degc: float
    air_degc: float
    lag_s: float
    chamber: ChamberLimits

    @classmethod
    def of(cls, recording: Recording, chamber: ChamberLimits) -> "ThermalResponse | None":
        """By what the unit's own thermometer recorded; None where it has none."""
        degc = recording.imu.columns.get("temperature")
        if degc is None:
            return None
        usual, room = float(np.nanmedian(degc)), recording.environment
        air = usual if room is None else float(np.nanmedian(room.columns["temperature"]))
        return cls(usual, air, _lag(recording.imu.t, degc), chamber)

    def course(self, t: np.ndarray, set_points: Sequence[SetPoint]) -> np.ndarray:
        """(n,) °C of the unit at even times t (s), as if it were in balance with the air before."""
        step = float(t[1] - t[0])
        most = self.chamber.rate_k_min / MINUTE_S
        air = np.full(len(t), self.air_degc)
        for at, target in set_points:
            later = t >= at
            from_degc = float(air[later][0])
            way = most * (t[later] - at)
            air[later] = from_degc + np.clip(target - from_degc, -way, way)
        stays = np.exp(-step / self.lag_s)
        return self.usual_degc + lfilter([1.0 - stays], [1.0, -stays], air - self.air_degc)


def _lag(t: np.ndarray, degc: np.ndarray) -> float:
    """Time constant (s) of a warm-up: the exponential that fits best."""
    known = np.isfinite(degc)
    cell = ((t[known] - t[known][0]) / CELL_S).astype(int)
    counts = np.maximum(np.bincount(cell), 1)
    means = np.bincount(cell, degc[known]) / counts
    middles = np.arange(len(means)) * CELL_S
    if len(means) < 4 or np.ptp(means) < TOLD:
        return USUAL_LAG
    missed = []
    for lag in LAGS:
        columns = np.column_stack([np.ones(len(means)), np.exp(-middles / lag)])
        found, *_ = np.linalg.lstsq(columns, means, rcond=None)
        missed.append(((means - columns @ found) ** 2).sum())
    return float(LAGS[int(np.argmin(missed))])
