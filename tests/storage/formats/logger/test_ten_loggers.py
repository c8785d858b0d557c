"""Ten loggers' files become the recording that they were written from, with nothing to rename."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.recording import ACCEL, GYRO
from storage.formats.convert import Changes
from storage.formats.logger.read import Understood, read_log
from tests.storage.formats.logger.makers.loggers import LOGGERS, bosch, movella_dot, protocol
from tests.tasks.readings.makers.bench import Bench, G, bench

SMALL = {"dwell": 4.0, "rates": (40.0,), "turns": (0.0,)}
Writer = Callable[[Bench, Path], tuple[Path, Path]]


def understood(log: Path, lines: Path | None, **changes: object) -> Understood:
    return read_log(log, lines, {}, Changes(gravity=G, **changes))  # type: ignore[arg-type]


@pytest.mark.parametrize("write", LOGGERS, ids=lambda one: one.__name__)
def test_a_loggers_file_is_the_recording_that_it_was_written_from(write, tmp_path):
    made = bench(5, **SMALL)
    found = understood(*write(made, tmp_path)).recording
    rows = len(found.imu)
    assert rows >= len(made.t) - 1
    np.testing.assert_allclose(found.imu.stack(GYRO), made.gyro[:rows], atol=2e-4)
    np.testing.assert_allclose(found.imu.stack(ACCEL), made.accel[:rows], atol=4e-4)
    began = found.imu.t - made.t[:rows]
    assert np.ptp(began) < 1e-3
    labels = found.manifest.segments or ()
    assert len(labels) == len(made.labels)
    for label, want in zip(labels, made.labels, strict=True):
        assert label.t_start - began[0] == pytest.approx(want["t_start"], abs=2e-3)
        assert label.t_end - began[0] == pytest.approx(want["t_end"], abs=2e-3)
        assert (label.up, label.axis, label.rate_deg_s) == (
            want.get("up"), want.get("axis"), want.get("rate_deg_s"),
        )  # fmt: skip


def test_what_is_not_written_anywhere_is_asked_in_one_question(tmp_path):
    log, _ = movella_dot(bench(6, **SMALL), tmp_path)
    with pytest.raises(Unusable, match="gyro: in which unit are Gyr_X, Gyr_Y, Gyr_Z"):
        understood(log, None)
    given = understood(log, None, units={"gyro": "deg/s"})
    assert given.recording.manifest.segments is None
    log.write_text("1,2,3,4\n2,3,4,5\n3,4,5,6\n")
    with pytest.raises(Unusable, match="--columns t=…,gyro_x=…"):
        understood(log, None)


def test_all_faults_of_a_bad_file_are_told_at_once(tmp_path):
    log, stated = bosch(bench(7, **SMALL), tmp_path)
    lines = log.read_text().splitlines()
    lines[200:400] = [line.replace(";", ";ovf", 1) for line in lines[200:400]]
    lines[60] += ";7"
    lines[71], lines[70] = lines[70], lines[71]
    log.write_text("\n".join(lines))
    rows = stated.read_text().splitlines()
    rows[2] = rows[2].replace("-z", "up?")
    rows[3] = "ten,20,+y,,,"
    stated.write_text("\n".join(rows))
    with pytest.raises(Unusable) as refused:
        understood(log, stated)
    sentence = str(refused.value)
    for part in ("ovf", "usual 8 fields", "line 61", "runs backwards", "line 3: up is", "line 4"):
        assert part in sentence


def test_counts_and_a_rate_of_rows_are_given_by_units(tmp_path):
    log = tmp_path / "raw.csv"
    rows = [f"{k % 3},{-k % 2},16384,131,-262,0" for k in range(500)]
    log.write_text("\n".join(["ax,ay,az,gx,gy,gz", *rows]))
    found = understood(log, None, units={"gyro": "131/dps", "t": "200Hz", "accel": "16384/g"})
    imu = found.recording.imu
    assert imu.t[-1] == pytest.approx(499 / 200)
    assert np.degrees(imu.columns["gyro_y"]).mean() == pytest.approx(-2.0)
    assert imu.columns["accel_z"].mean() == pytest.approx(G)


@pytest.mark.parametrize("clock", ["start", "first_row", "ms"])
def test_a_protocol_counts_on_any_clock(clock, tmp_path):
    made = bench(8, **SMALL)
    log = tmp_path / "log.csv"
    began = 4000.0
    values = np.column_stack([made.t + began, made.gyro, made.accel])
    names = "time (s),gx (rad/s),gy (rad/s),gz (rad/s),ax (m/s2),ay (m/s2),az (m/s2)"
    np.savetxt(log, values, delimiter=",", comments="", fmt="%.9f", header=names)
    forms = {
        "start": lambda s: f"{s + began:.3f}",
        "first_row": lambda s: f"{s:.3f}",
        "ms": lambda s: f"{1e3 * s:.0f}",
    }
    lines = protocol(made, tmp_path / "protocol.csv", forms[clock])
    if clock == "ms":
        lines.write_text(lines.read_text().replace("start,end", "start (ms),end (ms)"))
    labels = understood(log, lines).recording.manifest.segments or ()
    starts = [label.t_start for label in labels]
    np.testing.assert_allclose(starts, [one["t_start"] for one in made.labels], atol=2e-3)
