"""Predicts how a unit's temperature follows the set-points of a chamber."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.limits import ChamberLimits
from schemas.recording import Recording
from tasks.motion.lag import first_order_lag

MINUTE_S = 60.0
CELL_S = 5.0  # of a thermometer's means
LAGS = np.geomspace(30.0, 1500.0, 40)  # s, that are tried
USUAL_LAG = 300.0  # s, of a unit of which no warm-up tells it
LEAST_WARM_UP_K = 1.0  # a smaller one shows no time constant

SetPoint = tuple[float, float]  # s, °C


@dataclass(frozen=True)
class ThermalResponse:
    """usual_degc: of the unit when it is warm, and air_degc of the room, before anything is set.
    warm_up_k: by which it was colder when it was switched on. lag_s: time constant by which it
    warms up and follows the air.
    """

    usual_degc: float
    warm_up_k: float
    lag_s: float
    air_degc: float
    chamber: ChamberLimits

    @classmethod
    def of(cls, recording: Recording, chamber: ChamberLimits) -> "ThermalResponse | None":
        """By what the unit's own thermometer recorded; None where it has none."""
        degc = recording.imu.columns.get("temperature")
        if degc is None:
            return None
        room, median = recording.environment, float(np.nanmedian(degc))
        air = median if room is None else float(np.nanmedian(room.columns["temperature"]))
        return cls(*_warm_up(recording.imu.t, degc), air_degc=air, chamber=chamber)

    def temperatures(self, t: np.ndarray, set_points: Sequence[SetPoint]) -> np.ndarray:
        """(n,) °C of the unit at even times t (s) since it was switched on."""
        step = float(t[1] - t[0])
        most = self.chamber.rate_k_min / MINUTE_S
        air = np.full(len(t), self.air_degc)
        for at, target in set_points:
            later = t >= at
            from_degc = float(air[later][0])
            way = most * (t[later] - at)
            air[later] = from_degc + np.clip(target - from_degc, -way, way)
        heated = first_order_lag(air - self.air_degc, step, self.lag_s)
        return np.asarray(self.usual_degc - self.warm_up_k * np.exp(-t / self.lag_s) + heated)


def _warm_up(t: np.ndarray, degc: np.ndarray) -> tuple[float, float, float]:
    """°C in the end, K by which it was colder, and time constant (s): the exponential that fits
    best.
    """
    known = np.isfinite(degc)
    cell = ((t[known] - t[known][0]) / CELL_S).astype(int)
    counts = np.maximum(np.bincount(cell), 1)
    means = np.bincount(cell, degc[known]) / counts
    middles = np.arange(len(means)) * CELL_S
    if len(means) < 4 or np.ptp(means) < LEAST_WARM_UP_K:
        return float(np.median(means)), 0.0, USUAL_LAG
    tried = []
    for lag in LAGS:
        columns = np.column_stack([np.ones(len(means)), -np.exp(-middles / lag)])
        (end, colder), *_ = np.linalg.lstsq(columns, means, rcond=None)
        missed = float(((means - columns @ (end, colder)) ** 2).sum())
        tried.append((missed, float(end), float(colder), float(lag)))
    return min(tried)[1:]
