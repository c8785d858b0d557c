"""Files as ten loggers write them, by public descriptions of their layouts, from one bench's run.

Each writer takes a bench and a folder and returns the log and the protocol; it shares no code with
what reads them.
"""

import csv
import zipfile
from collections.abc import Callable
from datetime import datetime, timedelta
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np

from tests.tasks.readings.makers.bench import Bench, G

R2D = 180.0 / np.pi
G0 = G  # one g of these loggers is local gravity
Given = tuple[Path, Path]


def protocol(made: Bench, path: Path, time: Callable[[float], str] = "{:.3f}".format) -> Path:
    """start and end of each position and rate; what does not apply is empty."""
    with path.open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(["start", "end", "up", "turn_deg", "axis", "rate_deg_s"])
        for one in made.labels:
            out.writerow([
                time(one["t_start"]), time(one["t_end"]), one.get("up", ""),
                one.get("turn_deg", ""), one.get("axis", ""), one.get("rate_deg_s", ""),
            ])  # fmt: skip
    return path


def _write(
    path: Path, head: list[str], rows: list[str], newline: str = "\n", bom: str = ""
) -> Path:
    path.write_bytes((bom + newline.join([*head, *rows]) + newline).encode())
    return path


def _numbers(values: np.ndarray, form: str, separator: str) -> list[str]:
    return [separator.join(form % v for v in row) for row in values]


def xsens_mt(made: Bench, folder: Path) -> Given:
    """MT Manager: comment lines, tabs, a counter and a fine time of 10 kHz; m/s², rad/s."""
    head = ["// General information:", "//  Device Id: 00300000", "// Update Rate: 100.0Hz",
            "// Firmware Version: 1.0.0", "PacketCounter\tSampleTimeFine\tAcc_X\tAcc_Y\tAcc_Z\t"
            "Gyr_X\tGyr_Y\tGyr_Z\tMag_X\tMag_Y\tMag_Z\tRoll\tPitch\tYaw"]  # fmt: skip
    other = np.tile([0.3, 0.1, -0.4, 1.0, 2.0, 3.0], (len(made.t), 1))
    rows = [
        f"{k % 65536:05d}\t{round(t * 1e4) + 1234567}\t{text}"
        for k, (t, text) in enumerate(zip(
            made.t, _numbers(np.hstack([made.accel, made.gyro, other]), "%.6f", "\t"), strict=True
        ))
    ]  # fmt: skip
    log = _write(folder / "MT_0300.txt", head, rows)
    return log, protocol(made, folder / "protocol.csv")


def phyphox(made: Bench, folder: Path) -> Given:
    """phyphox: quoted names with units, semicolons and decimal commas in some locales."""
    names = [
        "Time (s)",
        *(f"Gyroscope {axis} (rad/s)" for axis in "xyz"),
        *(f"Acceleration {axis} (m/s^2)" for axis in "xyz"),
    ]
    head = [";".join(f'"{name}"' for name in names)]
    values = np.column_stack([made.t, made.gyro, made.accel])
    rows = [row.replace(".", ",") for row in _numbers(values, "%.9E", ";")]
    log = _write(folder / "Raw Data.csv", head, rows, "\r\n", "\ufeff")
    return log, protocol(made, folder / "protocol.csv")


def sensor_log(made: Bench, folder: Path) -> Given:
    """SensorLog: ISO times and times since boot, g, many columns; gravity removed in some."""
    names = ["loggingTime(txt)", "loggingSample(N)", "accelerometerTimestamp_sinceReboot(s)",
             *(f"accelerometerAcceleration{a}(G)" for a in "XYZ"),
             "gyroTimestamp_sinceReboot(s)", *(f"gyroRotation{a}(rad/s)" for a in "XYZ"),
             *(f"motionUserAcceleration{a}(G)" for a in "XYZ"),
             *(f"motionRotationRate{a}(rad/s)" for a in "XYZ"), "magnetometerX(µT)"]  # fmt: skip
    began = datetime(2026, 3, 2, 9, 15, 30, 250000)
    rows = []
    for k, t in enumerate(made.t):
        moment = (began + timedelta(seconds=float(t))).isoformat(timespec="milliseconds")
        a, w = made.accel[k] / G0, made.gyro[k]
        rows.append(",".join([
            f"{moment}+01:00", str(k), f"{t + 81234.5:.6f}", *(f"{v:.7f}" for v in a),
            f"{t + 81234.5:.6f}", *(f"{v:.7f}" for v in w), "0.001", "0.002", "0.003",
            *(f"{v:.7f}" for v in w + 0.001), "12.5",
        ]))  # fmt: skip
    log = _write(folder / "2026-03-02_09_15.csv", [",".join(names)], rows)
    stated = protocol(made, folder / "protocol.csv", lambda s: f"{s + 81234.5:.3f}")
    return log, stated


def vectornav(made: Bench, folder: Path) -> Given:
    """VectorNav: time since startup in ns, compensated readings beside others."""
    names = "TimeStartup,YprYaw,YprPitch,YprRoll,AccelX,AccelY,AccelZ,GyroX,GyroY,GyroZ,Temp"
    values = np.hstack([np.zeros((len(made.t), 3)), made.accel, made.gyro,
                        np.full((len(made.t), 1), 31.5)])  # fmt: skip
    rows = [
        f"{round(t * 1e9) + 52_000_000_000},{text}"
        for t, text in zip(made.t, _numbers(values, "%.7f", ","), strict=True)
    ]
    log = _write(folder / "vn200.csv", [names], rows)
    return log, protocol(made, folder / "protocol.csv", lambda s: f"{s + 52:.3f}")


def bosch(made: Bench, folder: Path) -> Given:
    """A Bosch evaluation tool: ms, mg and °/s in brackets, semicolons."""
    head = ["Sensor: BMI270; ODR 100 Hz", "Time(ms);Acc X(mg);Acc Y(mg);Acc Z(mg);"
            "Gyro X(°/s);Gyro Y(°/s);Gyro Z(°/s);Temperature(°C)"]  # fmt: skip
    values = np.column_stack([made.accel / G0 * 1e3, made.gyro * R2D, 0 * made.t + 25.0])
    rows = [
        f"{t * 1e3:.0f};{text}"
        for t, text in zip(made.t, _numbers(values, "%.4f", ";"), strict=True)
    ]
    log = _write(folder / "bmi270.csv", head, rows, "\r\n")
    return log, protocol(made, folder / "protocol.csv")


def arduino(made: Bench, folder: Path) -> Given:
    """A serial monitor's dump: its clock and an arrow, then raw counts; a last line cut off."""
    began = datetime(2026, 3, 2, 23, 58, 0)
    counts = np.column_stack([made.accel / G0 * 16384.0, made.gyro * R2D * 65.5])
    rows = [
        f"{(began + timedelta(seconds=float(t))).strftime('%H:%M:%S.%f')[:-3]} -> {text}"
        for t, text in zip(made.t, _numbers(np.rint(counts), "%d", ","), strict=True)
    ]
    rows[-1] = rows[-1][:25]
    head = ["23:57:59.900 -> ax,ay,az,gx,gy,gz"]
    log = _write(folder / "putty.log", ["MPU6050 connected", *head], rows)

    def time(s: float) -> str:
        return (began + timedelta(seconds=s)).strftime("%H:%M:%S.%f")[:-3]

    return log, protocol(made, folder / "protocol.csv", time)


def ulog(made: Bench, folder: Path) -> Given:
    """ulog2csv of sensor_combined: µs since boot, units in the names, indices in brackets."""
    names = ["timestamp", *(f"gyro_rad[{k}]" for k in range(3)), "gyro_integral_dt",
             "accelerometer_timestamp_relative", *(f"accelerometer_m_s2[{k}]" for k in range(3)),
             "accelerometer_integral_dt", "accelerometer_clipping"]  # fmt: skip
    rows = [
        ",".join([str(round(t * 1e6) + 7_654_321), *(f"{v:.8f}" for v in w), "10000", "0",
                  *(f"{v:.7f}" for v in a), "10000", "0"])
        for t, w, a in zip(made.t, made.gyro, made.accel, strict=True)
    ]  # fmt: skip
    log = _write(folder / "log_sensor_combined_0.csv", [",".join(names)], rows)
    return log, protocol(made, folder / "protocol.csv", lambda s: f"{s + 7.654321:.3f}")


def movella_dot(made: Bench, folder: Path) -> Given:
    """Movella DOT: sep line, preamble, µs, °/s without a word on the unit."""
    head = ["sep=,", "DeviceTag:,Xsens DOT", "FirmwareVersion:,2.0.0", "SyncStatus:,Not Synced",
            "OutputRate:,100Hz", "Measurement Mode:,Rate quantities", "",
            "PacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z"]  # fmt: skip
    values = np.column_stack([made.accel, made.gyro * R2D])
    rows = [
        f"{k + 1},{round(t * 1e6) + 3_999_000_000 & 0xFFFFFFFF},{text}"
        for k, (t, text) in enumerate(zip(made.t, _numbers(values, "%.6f", ","), strict=True))
    ]
    log = _write(folder / "dot_1.csv", head, rows)
    return log, protocol(made, folder / "protocol.csv")


def ni_daq(made: Bench, folder: Path) -> Given:
    """LabVIEW: a header with its end marks, tabs, decimal comma, names with units in words."""
    head = ["LabVIEW Measurement\t", "Writer_Version\t2", "Separator\tTab", "Decimal_Separator\t,",
            "***End_of_Header***\t", "\t", "Channels\t6", "Samples\t1\t1\t1\t1\t1\t1",
            "***End_of_Header***\t",
            "X_Value\tgx [dps]\tgy [dps]\tgz [dps]\tax [g]\tay [g]\taz [g]"]  # fmt: skip
    values = np.column_stack([made.t, made.gyro * R2D, made.accel / G0])
    rows = [row.replace(".", ",") for row in _numbers(values, "%.6f", "\t")]
    log = _write(folder / "daq.lvm", head, rows, "\r\n")
    return log, protocol(made, folder / "protocol.csv")


def workbook(made: Bench, folder: Path) -> Given:
    """A workbook: title, header, a row of units; the protocol in another workbook, by duration."""
    table = [["Bench log"], ["Date", "2026-03-02"], [],
             ["Time", "wx", "wy", "wz", "fx", "fy", "fz", "Temp"],
             ["s", "deg/s", "deg/s", "deg/s", "m/s²", "m/s²", "m/s²", "°C"]]  # fmt: skip
    values = np.column_stack([made.t, made.gyro * R2D, made.accel, 0 * made.t + 24.5])
    log = _xlsx(folder / "bench.xlsx", [*table, *values.round(7).tolist()])
    lines: list[list] = [
        ["what", "start (s)", "duration (s)", "position", "turn", "axis", "rate (deg/s)"]
    ]
    for one in made.labels:
        up = one.get("up", "")
        up = f"{up[1].upper()} {'up' if up[0] == '+' else 'down'}" if up else ""
        lines.append([
            one["name"], round(one["t_start"], 3), round(one["t_end"] - one["t_start"], 3), up,
            one.get("turn_deg", ""), one.get("axis", ""), one.get("rate_deg_s", ""),
        ])  # fmt: skip
    return log, _xlsx(folder / "protocol.xlsx", lines)


def _xlsx(path: Path, table: list[list]) -> Path:
    def cell(value: object) -> str:
        if isinstance(value, int | float):
            return f"<c><v>{value!r}</v></c>"
        return f'<c t="inlineStr"><is><t>{escape(str(value))}</t></is></c>' if value else "<c/>"

    rows = "".join(f"<row>{''.join(map(cell, row))}</row>" for row in table)
    name = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as book:
        book.writestr("xl/workbook.xml", f'<workbook xmlns="{name}"/>')
        book.writestr(
            "xl/worksheets/sheet1.xml",
            f'<worksheet xmlns="{name}"><sheetData>{rows}</sheetData></worksheet>',
        )
    return path


LOGGERS: tuple[Callable[[Bench, Path], Given], ...] = (
    xsens_mt, phyphox, sensor_log, vectornav, bosch, arduino, ulog, movella_dot, ni_daq, workbook,
)  # fmt: skip
