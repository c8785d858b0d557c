"""What may be wrong with a run that would pass: each manipulation of a recording by its name."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from schemas.recording import ACCEL, GYRO, Manifest, Recording, Segment, Stream
from tests.manifests import at_station

Manipulation = Callable[[Recording], Recording]
Change = Callable[[np.ndarray, np.ndarray], np.ndarray]  # of times and values

LATER = 7200.0  # s


def _stream(name: str, edit: Callable[[Stream], Stream | None]) -> Manipulation:
    def manipulate(recording: Recording) -> Recording:
        return replace(recording, **{name: edit(getattr(recording, name))})

    return manipulate


def _columns(name: str, columns: tuple[str, ...], change: Change) -> Manipulation:
    def edit(stream: Stream) -> Stream:
        made = {c: change(stream.t, stream.columns[c].copy()) for c in columns}
        return Stream(stream.t, {**stream.columns, **made})

    return _stream(name, edit)


def _without(name: str, column: str) -> Manipulation:
    return _stream(name, lambda s: Stream(s.t, {c: v for c, v in s.columns.items() if c != column}))


def _kept(name: str, keep: Callable[[np.ndarray], np.ndarray]) -> Manipulation:
    """The rows of a stream at times (n,) for which `keep` says so."""
    return _stream(name, lambda s: s.at(keep(s.t)))


def _time(name: str, change: Callable[[np.ndarray], np.ndarray]) -> Manipulation:
    return _stream(name, lambda s: Stream(change(s.t), s.columns))


def _manifest(**changes: Any) -> Manipulation:
    def manipulate(recording: Recording) -> Recording:
        fields = recording.manifest.model_dump() | changes
        return replace(recording, manifest=Manifest.model_validate(fields))

    return manipulate


def _station(**changes: Any) -> Manipulation:
    return lambda recording: at_station(recording, **changes)


def _segments(change: Callable[[int, Segment], Segment], kind: str) -> Manipulation:
    """Every segment of a kind changed, by its number among them."""

    def manipulate(recording: Recording) -> Recording:
        chosen = [s.name for s in recording.manifest.segments or () if s.kind == kind]
        segments = tuple(
            change(chosen.index(s.name), s) if s.kind == kind else s
            for s in recording.manifest.segments or ()
        )
        manifest = recording.manifest.model_copy(update={"segments": segments})
        return replace(recording, manifest=manifest)

    return manipulate


def _in_segments(columns: tuple[str, ...], kind: str, only: int | None, change: Change):
    """Columns of the unit's stream changed in every segment of a kind, or in one of them."""

    def manipulate(recording: Recording) -> Recording:
        held = [s for s in recording.manifest.segments or () if s.kind == kind]
        made = {c: recording.imu.columns[c].copy() for c in columns}
        for segment in held if only is None else held[only : only + 1]:
            rows = recording.imu.rows(segment.t_start, segment.t_end)
            for values in made.values():
                values[rows] = change(recording.imu.t[rows], values[rows])
        imu = Stream(recording.imu.t, {**recording.imu.columns, **made})
        return replace(recording, imu=imu)

    return manipulate


def _both(*parts: Manipulation) -> Manipulation:
    def manipulate(recording: Recording) -> Recording:
        for part in parts:
            recording = part(recording)
        return recording

    return manipulate


def _share(t: np.ndarray) -> np.ndarray:
    """0 at the beginning, 1 at the end."""
    return (t - t[0]) / (t[-1] - t[0])


def _after(t: np.ndarray, share: float) -> np.ndarray:
    return 1.0 * (_share(t) > share)


def _some(t: np.ndarray, share: float) -> np.ndarray:
    return np.random.default_rng(1).random(len(t)) < share


def _off(share: float, sigmas: float) -> Change:
    """A share of the samples off by so many standard deviations of one second's noise."""

    def change(t: np.ndarray, values: np.ndarray) -> np.ndarray:
        sigma = 1.4826 * np.median(np.abs(np.diff(values))) / np.sqrt(2.0)
        return values + sigmas * sigma * _some(t, share)

    return change


def _mid(t: np.ndarray, seconds: float) -> np.ndarray:
    return np.abs(t - 0.5 * (t[0] + t[-1])) < 0.5 * seconds


def _outer(change: Change) -> Manipulation:
    def manipulate(recording: Recording) -> Recording:
        axis = (recording.manifest.station.table_axes or ())[0].name
        return _columns("table", (f"{axis}_angle",), change)(recording)

    return manipulate


def _spin_labels(i: int, segment: Segment) -> Segment:
    return segment.model_copy(update={"rate_deg_s": 1.01 * (segment.rate_deg_s or 0.0)})


def _shaken(size: float) -> Change:
    return lambda t, values: values + size * np.random.default_rng(2).standard_normal(len(t))


def _swapped(one: str, other: str) -> Manipulation:
    def edit(stream: Stream) -> Stream:
        columns = stream.columns
        return Stream(stream.t, {**columns, one: columns[other], other: columns[one]})

    return _stream("imu", edit)


NO_TABLE = _stream("table", lambda table: None)
DEG = float(np.radians(1.0))
UNSETTLED = {"code": "table_unsettled", "en": "Not settled.", "zh": "未稳定。", "segments": ["a"]}

MANIPULATIONS: dict[str, Manipulation] = {
    "air for the first 5 %": _kept("environment", lambda t: _share(t) < 0.05),
    "air for one row": _kept("environment", lambda t: t == t[0]),
    "air hours before": _time("environment", lambda t: t - LATER),
    "air hours after": _time("environment", lambda t: t + LATER),
    "air for the last half": _kept("environment", lambda t: _share(t) > 0.5),
    "air with a gap of ten minutes": _kept("environment", lambda t: ~_mid(t, 600.0)),
    "no air": _stream("environment", lambda air: None),
    "no humidity": _without("environment", "humidity"),
    "air too warm": _columns("environment", ("temperature",), lambda t, v: v + 10.0),
    "air too warm for a minute": _columns(
        "environment", ("temperature",), lambda t, v: v + 10.0 * _mid(t, 60.0)
    ),
    "air too cold at the end": _columns(
        "environment", ("temperature",), lambda t, v: v - 8.0 * _after(t, 0.8)
    ),
    "air too humid": _columns("environment", ("humidity",), lambda t, v: v + 50.0),
    "supply from 12 to 5 V": _columns(
        "environment", ("supply_voltage",), lambda t, v: 12.0 - 7.0 * _share(t)
    ),
    "supply falls by a tenth": _columns(
        "environment", ("supply_voltage",), lambda t, v: v * (1.0 - 0.1 * _share(t))
    ),
    "supply drops for a minute": _columns(
        "environment", ("supply_voltage",), lambda t, v: v * (1.0 - 0.5 * _mid(t, 60.0))
    ),
    "supply off": _columns("environment", ("supply_voltage",), lambda t, v: 0.0 * v),
    "supply of a hundred volts": _columns(
        "environment", ("supply_voltage",), lambda t, v: 100.0 + 0.0 * v
    ),
    "no supply": _without("environment", "supply_voltage"),
    "unit at 85 °C": _columns("imu", ("temperature",), lambda t, v: 85.0 + 0.0 * v),
    "unit at −40 °C": _columns("imu", ("temperature",), lambda t, v: -40.0 + 0.0 * v),
    "unit warms by 40 K": _columns("imu", ("temperature",), lambda t, v: v + 40.0 * _share(t)),
    "unit warms by 20 K at once": _columns(
        "imu", ("temperature",), lambda t, v: v + 20.0 * _after(t, 0.5)
    ),
    "no temperature of the unit": _without("imu", "temperature"),
    "gravity 9.71": _station(gravity_m_s2=9.71),
    "gravity of the equator": _station(gravity_m_s2=9.780),
    "gravity of the pole": _station(gravity_m_s2=9.832),
    "no gravity": _station(gravity_m_s2=None),
    "latitude of the wrong sign": _station(latitude_deg=-39.9),
    "latitude 0°": _station(latitude_deg=0.0),
    "latitude 90°": _station(latitude_deg=90.0),
    "latitude 65°": _station(latitude_deg=65.0),
    "no latitude": _station(latitude_deg=None),
    "heading wrong by 90°": _station(heading_deg=90.0),
    "heading wrong by 180°": _station(heading_deg=180.0),
    "heading wrong by −90°": _station(heading_deg=-90.0),
    "no table, labels 1 % off": _both(NO_TABLE, _segments(_spin_labels, "rate")),
    "no table": NO_TABLE,
    "table for the first half": _kept("table", lambda t: _share(t) < 0.5),
    "table with a gap of a minute": _kept("table", lambda t: ~_mid(t, 60.0)),
    "table without every third row": _kept("table", lambda t: np.arange(len(t)) % 3 > 0),
    "table a twentieth lost": _kept("table", lambda t: ~_some(t, 0.05)),
    "encoder jumps by 1 rad": _outer(lambda t, v: v + _after(t, 0.5)),
    "encoder jumps by 1 rad at the beginning": _outer(lambda t, v: v + _after(t, 0.05)),
    "encoder jumps by 1 rad for a second": _outer(lambda t, v: v + _mid(t, 1.0)),
    "encoder 1 % too large": _outer(lambda t, v: 1.01 * v),
    "encoder turned round": _outer(lambda t, v: -v),
    "encoder stands": _outer(lambda t, v: 0.0 * v),
    "labels 1 % off": _segments(_spin_labels, "rate"),
    "labels of rates the other way": _segments(
        lambda i, s: s.model_copy(update={"rate_deg_s": -(s.rate_deg_s or 0.0)}), "rate"
    ),
    "one label of a rate off": _segments(lambda i, s: _spin_labels(i, s) if i == 3 else s, "rate"),
    "labels 10 s late": _both(
        *(
            _segments(
                lambda i, s: s.model_copy(
                    update={"t_start": s.t_start + 10.0, "t_end": s.t_end + 10.0}
                ),
                kind,
            )
            for kind in ("static", "rate")
        )
    ),
    "a position upside down": _segments(
        lambda i, s: s.model_copy(update={"up": "-" + s.up[1]}) if i == 0 and s.up else s, "static"
    ),
    "10 % off by 5 σ": _columns("imu", GYRO + ACCEL, _off(0.1, 5.0)),
    "10 % of a gyro off by 5 σ": _columns("imu", GYRO[1:2], _off(0.1, 5.0)),
    "2 % of an accelerometer off by 8 σ": _columns("imu", ACCEL[:1], _off(0.02, 8.0)),
    "a channel stands": _in_segments(GYRO[:1], "rate", 2, lambda t, v: v[0] + 0.0 * v),
    "50 m/s² in the rests": _in_segments(ACCEL, "static", None, _shaken(50.0)),
    "1 m/s² in one rest": _in_segments(ACCEL, "static", 2, _shaken(1.0)),
    "gyros shaken in the rests": _in_segments(GYRO, "static", None, _shaken(2.0 * DEG)),
    "a gyro shaken in one rest": _in_segments(GYRO[2:], "static", 1, _shaken(1.0 * DEG)),
    "gyros of the wrong sign": _columns("imu", GYRO, lambda t, v: -v),
    "two gyros change places": _swapped(GYRO[0], GYRO[1]),
    "a rest that turns": _in_segments(GYRO[2:], "static", 4, lambda t, v: v + 5.0 * DEG),
    "a twentieth lost": _kept("imu", lambda t: ~_some(t, 0.05)),
    "a minute lost": _kept("imu", lambda t: ~_mid(t, 60.0)),
    "unit a second late": _time("imu", lambda t: t + 1.0),
    "unit half a second early": _time("imu", lambda t: t - 0.5),
    "unit's clock 0.1 % fast": _time("imu", lambda t: 1.001 * t),
    "table two seconds late": _time("table", lambda t: t + 2.0),
    "table not settled": _manifest(station_remarks=[UNSETTLED]),
}

# These are held against the uncertainty that the method states for the run itself.
DRIFTS: dict[str, Manipulation] = {
    "gyros drift by 0.5 °/s": _columns("imu", GYRO, lambda t, v: v + 0.5 * DEG * _share(t)),
    "one gyro drifts by 0.5 °/s": _columns("imu", GYRO[:1], lambda t, v: v - 0.5 * DEG * _share(t)),
    "accelerometers drift": _columns("imu", ACCEL, lambda t, v: v + 0.2 * _share(t)),
    "gyros jump by 0.3 °/s": _columns("imu", GYRO, lambda t, v: v + 0.3 * DEG * _after(t, 0.5)),
    "accelerometers jump": _columns("imu", ACCEL, lambda t, v: v + 0.1 * _after(t, 0.3)),
    "gyros go to and fro": _columns(
        "imu", GYRO, lambda t, v: v + 0.2 * DEG * np.sin(20.0 * _share(t))
    ),
}
