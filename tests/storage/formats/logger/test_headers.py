"""Columns, units and clocks are found in headers as loggers write them, in any letters."""

from pathlib import Path

import numpy as np
import pytest

from schemas.base import Unusable
from storage.formats.convert import Changes
from storage.formats.logger.read import Understood, read_log

ROWS = 300
T = np.arange(ROWS) * 0.01
RNG = np.random.default_rng(4)
RATE = RNG.normal(0.0, 0.5, (ROWS, 3))
FORCE = np.array([0.0, 0.0, 1.0]) + RNG.normal(0.0, 0.004, (ROWS, 3))
G = 9.80665
DEG = np.pi / 180.0
ISO = np.datetime_as_string(
    np.datetime64("2026-03-02T10:00:00.000") + np.arange(ROWS) * np.timedelta64(10, "ms")
)
W3, A3 = RATE.T, FORCE.T
WIT = "Time(s)\tax(g)\tay(g)\taz(g)\twx(deg/s)\twy(deg/s)\twz(deg/s)\tAngleX(deg)\tT(°)"
CHINESE = "时间(s),加速度X(g),加速度Y(g),加速度Z(g),角速度X(°/s),角速度Y(°/s),角速度Z(°/s),温度(°C)"
ROS = (
    "%time,field.orientation.x,field.angular_velocity.x,field.angular_velocity.y,"
    "field.angular_velocity.z,field.linear_acceleration.x,field.linear_acceleration.y,"
    "field.linear_acceleration.z"
)
PER = ",".join(
    ["timestamp", *(f"gyro_{a}_rad_per_s" for a in "xyz"), *(f"accel_{a}_m_per_s2" for a in "xyz")]
)
TURN = ";".join(
    ["UTC Time", *(f"Rate of Turn {a} [deg/s]" for a in "XYZ"),
     *(f"Specific Force {a} [mg]" for a in "XYZ")]
)  # fmt: skip
FLIGHT = ",".join(
    ["loopIteration", "time (us)", *(f"gyroADC[{k}] (deg/s)" for k in range(3)),
     *(f"accSmooth[{k}]" for k in range(3))]
)  # fmt: skip
PHONE = "timestamp_ns,AccX,AccY,AccZ,GyroX,GyroY,GyroZ,MagX,MagY,MagZ"
DATED = "Date,Time,Gx (dps),Gy (dps),Gz (dps),Ax (g),Ay (g),Az (g)"
NUMBERED = "t,Gyro1,Gyro2,Gyro3,Acc1,Acc2,Acc3"
OTHER = np.full(ROWS, 21.5)
DAY, HOURS = np.full(ROWS, "02/03/2026"), np.array([f"10:00:{t:06.3f}" for t in T])
NS = (T * 1e9).round().astype(np.int64)
# name: header, columns, encoding, units given, what one of the written rates is in rad/s
HEADERS: dict[str, tuple[str, tuple, str, dict[str, str], float]] = {
    "tabs": (WIT, (T, *A3, *W3, OTHER, OTHER), "utf-8", {}, DEG),
    "Chinese": (CHINESE, (T, *A3, *W3, OTHER), "gb18030", {}, DEG),
    "ROS": (ROS, (NS + 17 * 10**17, OTHER, *W3, *(G * A3)), "utf-8", {"gyro": "rad/s"}, 1.0),
    "spaces": ("# t gx gy gz ax ay az", (T, *W3, *(G * A3)), "utf-8", {"gyro": "rad/s"}, 1.0),
    "numbered": (NUMBERED, (T, *W3, *(G * A3)), "utf-8", {"gyro": "dps"}, DEG),
    "epoch in ms": (PER, (NS // 10**6 + 17 * 10**11, *W3, *(G * A3)), "utf-8", {}, 1.0),
    "ISO": (TURN, (ISO, *W3, *(1e3 * A3)), "cp1252", {}, DEG),
    "date and time": (DATED, (DAY, HOURS, *W3, *A3), "utf-8", {}, DEG),
    "counts": (FLIGHT, (np.arange(ROWS), NS // 1000, *W3, *(2048 * A3)), "utf-8", {}, DEG),
    "phone": (PHONE, (NS + 81 * 10**12, *(G * A3), *W3, *[OTHER] * 3), "utf-8",
              {"gyro": "rad/s"}, 1.0),
}  # fmt: skip


def read(
    path: Path, header: str, columns: tuple, encoding: str = "utf-8", **units: str
) -> Understood:
    sign = next((s for s in "\t;," if s in header), " ")
    text = [[v if isinstance(v, str) else f"{v:.9g}" if isinstance(v, float) else str(v)
             for v in column.tolist()] for column in columns]  # fmt: skip
    rows = [sign.join(row) for row in zip(*text, strict=True)]
    path.write_bytes("\n".join([header, *rows]).encode(encoding))
    return read_log(path, None, {}, Changes(units=units))


@pytest.mark.parametrize("name", HEADERS)
def test_a_header_is_understood(tmp_path, name):
    header, columns, encoding, units, unit = HEADERS[name]
    imu = read(tmp_path / "log.csv", header, columns, encoding, **units).recording.imu
    np.testing.assert_allclose(imu.t - imu.t[0], T, atol=1e-6)
    for k, axis in enumerate("xyz"):
        np.testing.assert_allclose(imu.columns[f"gyro_{axis}"], unit * RATE[:, k], atol=1e-6)
        np.testing.assert_allclose(imu.columns[f"accel_{axis}"], G * FORCE[:, k], atol=1e-6)


def test_two_units_in_one_table_are_asked_for(tmp_path):
    header = ",".join(["t", *(f"imu{n}_gyro_{a}" for n in (0, 1) for a in "xyz"), "ax", "ay", "az"])
    with pytest.raises(Unusable, match="imu0_gyro_x or imu1_gyro_x: which are they"):
        read(tmp_path / "log.csv", header, (T, *W3, *W3, *A3))


def test_rows_without_a_time_need_their_rate(tmp_path):
    columns = (*A3, *W3)
    with pytest.raises(Unusable, match="t=100Hz"):
        read(tmp_path / "log.csv", "ax,ay,az,gx,gy,gz", columns, gyro="dps")
    given = read(tmp_path / "log.csv", "ax,ay,az,gx,gy,gz", columns, gyro="dps", t="100Hz")
    np.testing.assert_allclose(given.recording.imu.t, T)


GERMAN = """Gerät 7
Datum/Zeit;Gyr X [°/s];Gyr Y [°/s];Gyr Z [°/s];Acc X [{0}];Acc Y [{0}];Acc Z [{0}]
04.03.2026 08:15:00,000;0,1;-0,2;0,3;0,01;0,02;{1}
04.03.2026 08:15:00,010;0,1;-0,2;0,3;0,01;0,02;{1}
04.03.2026 08:15:00,020;0,1;-0,2;0,3;0,01;0,02;{1}
"""


def test_a_time_is_known_by_its_form_whatever_its_column_is_called(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text(GERMAN.format("g", "1,00"), encoding="utf-8")
    understood = read_log(log, None, {}, Changes())
    assert understood.recording.imu.t == pytest.approx([0.0, 0.01, 0.02])
    assert (understood.recording.manifest.model_extra or {})["acquired_at"].startswith(
        "2026-03-04T"
    )


@pytest.mark.parametrize(
    ("unit", "read", "known", "note"),
    [("g", "1,00", 9.80665, "biases in m/s² may"), ("m/s²", "9,81", None, "are not determined")],
)
def test_local_gravity_is_assumed_only_where_a_ratio_to_it_does_not_depend_on_it(
    tmp_path, unit, read, known, note
):
    log = tmp_path / "log.csv"
    log.write_text(GERMAN.format(unit, read), encoding="utf-8")
    understood = read_log(log, None, {}, Changes())
    assert understood.recording.manifest.station.gravity_m_s2 == known
    assert any(note in each for each in understood.notes)
