"""Ways of parting a run by time and by what was recorded: temperatures, humidity, supply."""

from collections.abc import Callable, Iterator

import numpy as np

from schemas.discrepancy import Dimension
from schemas.recording import ACCEL, ANGLE, GYRO, Recording
from tasks.explain.locate.regime import Regime
from tasks.model.term import Text

PARTS = 10  # of the range of a course
UNIT_TEMPERATURE: Text = ("the unit's temperature", "器件温度")
QUANTITIES: dict[str, tuple[Text, str]] = {
    "temperature": (("the air's temperature", "环境温度"), " °C"),
    "humidity": (("humidity", "湿度"), " %"),
    "supply_voltage": (("supply voltage", "电源电压"), " V"),
    "pressure": (("air pressure", "气压"), " hPa"),
}


def by_time(t: np.ndarray) -> Regime:
    """By tenths of the run."""
    return _by_course("time", t, ("the time", "时间"), " s")


def by_records(recording: Recording, t: np.ndarray) -> Iterator[Regime]:
    """By the unit's own temperature and by every other course that was recorded."""
    imu, room = recording.imu, recording.environment
    for name, course in imu.columns.items():
        own = np.interp(t, imu.t, course)
        if name == "temperature":
            yield _by_course("temperature", own, UNIT_TEMPERATURE, " °C")
        elif name not in (*GYRO, *ACCEL, *ANGLE):
            yield _by_course("recorded", own, (name, name), "")
    for name, course in (room.columns if room is not None else {}).items():
        known = np.isfinite(course)
        if room is not None and known.any():
            title, unit = QUANTITIES.get(name, ((name, name), ""))
            yield _by_course("recorded", np.interp(t, room.t[known], course[known]), title, unit)


def _by_course(dimension: Dimension, course: np.ndarray, follows: Text, unit: str) -> Regime:
    """By equal parts of a course's range."""
    known = np.isfinite(course)
    if not known.any():
        return Regime(dimension, np.full(len(course), -1), True, follows, (), _between(course, ""))
    edges = np.linspace(course[known].min(), course[known].max(), PARTS + 1)
    cell = np.where(known, np.searchsorted(edges[1:-1], course), -1)
    cells = tuple(
        (f"at {x}{unit}", f"{x}{unit} 时")
        for x in (_shown(each, edges) for each in 0.5 * (edges[1:] + edges[:-1]))
    )
    return Regime(dimension, cell, True, follows, cells, _between(edges, unit), dimension != "time")


def _shown(value: float, edges: np.ndarray) -> str:
    """A value with as many decimals as tell hundredths of the range apart."""
    span = max(float(np.ptp(edges)), 1e-9)
    return f"{value:.{max(0, 2 - int(np.floor(np.log10(span))))}f}"


def _between(edges: np.ndarray, unit: str) -> Callable[[list[int]], Text]:
    def at(cells: list[int]) -> Text:
        low, high = (_shown(each, edges) for each in (edges[cells[0]], edges[cells[-1] + 1]))
        return f"from {low} to {high}{unit}", f"{low} 至 {high}{unit}"

    return at
