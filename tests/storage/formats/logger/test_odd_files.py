"""Odd and broken files of loggers: one true sentence, or values and what was left out."""

from pathlib import Path

import numpy as np
import pytest

from schemas.base import Unusable
from storage.formats.convert import Changes
from storage.formats.logger.read import Understood, read_log

HEADER = "t (s),gx (dps),gy (dps),gz (dps),ax (g),ay (g),az (g)"


def row(k: int) -> list[str]:
    return [f"{0.01 * k:.2f}", "0.1", f"{0.001 * k:.3f}", "-0.3", "0.01", "0.02", "1.00"]


def rows(count: int = 300) -> list[str]:
    return [",".join(row(k)) for k in range(count)]


def read(path: Path, lines: list[str], protocol: str | None = None, **columns: str) -> Understood:
    log, labels = path / "log.csv", path / "p.csv"
    log.write_text("\n".join(lines) + "\n", encoding="utf-8")
    if protocol is not None:
        labels.write_text(protocol, encoding="utf-8")
    return read_log(log, labels if protocol else None, columns, Changes(gravity=9.80665))


@pytest.mark.parametrize("cell", ["", "NaN", "inf", "OVF", "-", "1e400"])
def test_a_cell_without_a_number_leaves_its_row_out_of_the_triad(tmp_path, cell):
    lines = [HEADER, *rows()]
    lines[101] = ",".join([*row(100)[:2], cell, *row(100)[3:]])
    understood = read(tmp_path, lines)
    gyro = understood.recording.imu.stack(("gyro_x", "gyro_y", "gyro_z"))
    assert np.flatnonzero(np.isnan(gyro).any(axis=1)).tolist() == [100]
    assert np.isfinite(understood.recording.imu.columns["accel_x"]).all()
    (note,) = [each for each in understood.notes if "no numbers" in each]
    assert "column gy (dps): 1 of 300 values" in note
    assert "line 102" in note


def test_many_cells_without_a_number_are_a_fault_of_the_files_own_column(tmp_path):
    lines = [HEADER, *(",".join([*row(k)[:2], "", *row(k)[3:]]) for k in range(20)), *rows()[20:]]
    with pytest.raises(Unusable, match=r"column gy \(dps\): 20 of 300 values are no numbers"):
        read(tmp_path, lines)


@pytest.mark.parametrize("every", [1, 2, 3])
def test_a_sensor_that_is_read_less_often_is_left_out_between(tmp_path, every):
    lines = [HEADER, *(",".join([*row(k)[:4], *(row(k)[4:] if k % every == 0 else [""] * 3)])
                       for k in range(300))]  # fmt: skip
    accel = read(tmp_path, lines).recording.imu.columns["accel_z"]
    assert np.flatnonzero(np.isfinite(accel)).tolist() == list(range(0, 300, every))


def test_rows_of_one_sensor_each_are_told(tmp_path):
    lines = [HEADER, *(",".join([row(k)[0], *(row(k)[1:4] if k % 2 else [""] * 3),
                                 *([""] * 3 if k % 2 else row(k)[4:])])
                       for k in range(300))]  # fmt: skip
    with pytest.raises(Unusable, match="none holds both: give one row for each stamp"):
        read(tmp_path, lines)


def test_decimal_commas_between_commas_are_told(tmp_path):
    lines = [HEADER, *(each.replace(".", ",") for each in rows())]
    with pytest.raises(Unusable, match="14 fields below a header of 7: commas in numbers"):
        read(tmp_path, lines)


def test_a_name_that_stands_twice_is_told_and_one_that_is_given_leaves_the_others(tmp_path):
    lines = [HEADER.replace("gy (dps)", "gx (dps)"), *rows()]
    with pytest.raises(Unusable, match=r"gx \(dps\) stands twice in the header"):
        read(tmp_path, lines)
    understood = read(tmp_path, lines, gyro_x="2", gyro_y="3", gyro_z="4")
    assert understood.recording.imu.columns["gyro_y"][-1] == pytest.approx(np.radians(0.299))


def test_rows_of_two_sensors_are_not_one_unit(tmp_path):
    lines = [f"{HEADER},id", *(f"{each},{1 + k % 2}" for k, each in enumerate(rows()))]
    with pytest.raises(Unusable, match=r"column id tells 2 sensors apart \(1, 2\)"):
        read(tmp_path, lines)


def test_a_header_that_stands_again_is_left_out(tmp_path):
    lines = [HEADER, *rows()[:150], HEADER, *rows()[150:]]
    understood = read(tmp_path, lines)
    assert len(understood.recording.imu) == 300
    assert any("header stands again in line 152" in note for note in understood.notes)


def test_one_time_for_all_rows_is_told_as_that(tmp_path):
    lines = [HEADER, *(",".join(["1.7e15", *row(k)[1:]]) for k in range(50))]
    with pytest.raises(Unusable, match="every row has the same time; give the rate of the rows"):
        read(tmp_path, lines)


def test_a_single_row_is_no_recording(tmp_path):
    with pytest.raises(Unusable, match="has 1 row of data"):
        read(tmp_path, [HEADER, rows()[0]])


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("0.5,1.5,5,+z,,,", "line 2: end and duration contradict each other"),
        ("0.5,1.5,,,z,10,90", "line 2: a rate is held or an angle turned"),
        ("0.5,inf,,+z,,,", "line 2: end is 'inf', no time"),
        ("0.5,0.5,,+z,,,", "line 2: it starts at 0.5 s and ends at 0.5 s"),
        ("soon,1.5,,+z,,,", "line 2: start is 'soon', no time"),
    ],
)
def test_a_line_of_the_protocol_that_cannot_be_is_told_by_what_is_wrong(tmp_path, line, sentence):
    protocol = f"start,end,duration,up,axis,rate_deg_s,angle_deg\n{line}\n1.6,2.6,,+z,,,\n"
    with pytest.raises(Unusable, match=sentence):
        read(tmp_path, [HEADER, *rows()], protocol)


def test_names_of_a_common_sketch_are_known(tmp_path):
    lines = [
        "ms,AcX,AcY,AcZ,GyX,GyY,GyZ",
        *(f"{10 * k},10,{k % 7},16384,13,-5,{k}" for k in range(300)),
    ]
    log = tmp_path / "log.csv"
    log.write_text("\n".join(lines) + "\n", encoding="utf-8")
    changes = Changes(units={"gyro": "131/dps", "accel": "16384/g"}, gravity=9.80665)
    imu = read_log(log, None, {}, changes).recording.imu
    assert imu.t[-1] == pytest.approx(2.99)
    assert imu.columns["accel_z"][0] == pytest.approx(9.80665)
    assert imu.columns["gyro_z"][262] == pytest.approx(np.radians(2.0))
