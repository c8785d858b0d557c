"""What stands in a logger's table that is no reading, or no time, is put right exactly or told in
one sentence; a table with pauses, taps, saturation, slow or coarse rows is let be.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.recording import ACCEL, GYRO, Recording
from schemas.text import Remark
from storage.formats.convert import Changes
from storage.home import Home
from tasks.readings.codes import codes_put_right, offset_taken_off
from tasks.stages import logger_table
from tasks.words import argument, say
from tests.storage.formats.logger.makers.loggers import protocol
from tests.tasks.readings.makers.bench import DEG, Bench, G, bench

NAMES = ("gx (deg/s)", "gy (deg/s)", "gz (deg/s)", "ax (m/s2)", "ay (m/s2)", "az (m/s2)")
COUNTS = ("gx", "gy", "gz", "ax", "ay", "az")
RAW = {"gyro": "65.5/dps", "accel": "4096/g"}


@pytest.fixture(autouse=True)
def without_pictures(monkeypatch) -> None:
    monkeypatch.setattr(logger_table, "draw_recording", lambda _recording, path: path)


def made(seed: int, hertz: float = 50.0, **changes: object) -> Bench:
    kept = {"dwell": 4.0, "rates": (40.0, 90.0), "turns": (0.0,), "margin": 0.3}
    return bench(seed, hertz=hertz, **{**kept, **changes})  # type: ignore[arg-type]


def readings(one: Bench, decimals: int = 4) -> np.ndarray:
    """(n, 6) in deg/s and m/s²."""
    return np.round(np.hstack([one.gyro / DEG, one.accel]), decimals)


def counts(one: Bench) -> np.ndarray:
    return np.rint(np.hstack([one.gyro / DEG * 65.5, one.accel * 4096.0 / 9.80665]))


def understood(
    folder: Path, one: Bench, values: np.ndarray, *, stamps: np.ndarray | None = None,
    sign: str = ",", time: str = "t (s)", names: Sequence[str] = NAMES,
    header_before: int | None = None,
    units: dict[str, str] | None = None,
) -> tuple[Recording, tuple[Remark, ...]]:  # fmt: skip
    header = sign.join([time, *names])
    at = one.t if stamps is None else stamps
    rows = [sign.join([f"{t:.12g}", *(f"{v:.10g}" for v in row)])
            for t, row in zip(at, values.tolist(), strict=True)]  # fmt: skip
    if header_before is not None:
        rows.insert(header_before, header)
    table = folder / "log.csv"
    table.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    lines = protocol(one, folder / "protocol.csv", lambda s: f"{s:.3f}")
    shown = logger_table.understand(
        table, Home(folder / "home"), protocol=lines, columns={},
        changes=Changes(gravity=G, units=units or {}),
    )  # fmt: skip
    for doubt in shown.doubts:
        assert say(doubt, "en").endswith(".")
        assert say(doubt, "zh").endswith("。")
    return shown.understood.recording, shown.doubts


def codes(doubts: Sequence[Remark]) -> list[str]:
    return [one.code for one in doubts]


@pytest.mark.parametrize(
    ("triad", "mark", "rows"),
    [
        (ACCEL, (0.0, 0.0, 0.0), slice(1, None, 3)),
        (GYRO, (9999.0, 9999.0, 9999.0), slice(40, None, 700)),
        (GYRO, (0.0, 0.0, 0.0), slice(0, None, 4)),
        (ACCEL, (-156.9064, -156.9064, 156.9064), slice(-25, None)),
        (ACCEL, (327.67, 327.67, 327.67), slice(0, None, 2)),
    ],
)
def test_marks_of_no_data_are_left_out_exactly(tmp_path, triad, mark, rows):
    one = made(11, 50.0)
    values = readings(one)
    first = 0 if triad is GYRO else 3
    marked = values.copy()
    marked[rows, first : first + 3] = mark
    found, doubts = understood(tmp_path, one, marked, sign=";")
    assert codes(doubts) == ["no_data"]
    read = found.imu.stack(triad)
    lost = np.isnan(read).any(axis=1)
    assert np.flatnonzero(lost).tolist() == np.arange(len(values))[rows].tolist()
    factor = DEG if triad is GYRO else 1.0
    np.testing.assert_allclose(read[~lost], values[~lost, first : first + 3] * factor, atol=1e-9)


@pytest.mark.parametrize(
    ("step", "place", "unit", "factor"),
    [
        (37.0, 0.4, "s", 1.0),
        (-3600.0, 0.7, "ms", 1e3),
        (2.5e6, 0.2, "us", 1e6),
        (-4.0, 0.5, "s", 1.0),
    ],
)
def test_a_step_of_the_clock_is_taken_out_where_no_row_is_missing(
    tmp_path, step, place, unit, factor
):
    one = made(12)
    stamps = one.t + 5000.0 + step * (np.arange(len(one.t)) >= place * len(one.t))
    found, doubts = understood(
        tmp_path, one, readings(one), stamps=factor * stamps, time=f"t ({unit})"
    )
    assert codes(doubts) == ["clock_set"]
    np.testing.assert_allclose(found.imu.t - found.imu.t[0], one.t, atol=2e-3 / 100.0)
    assert f"{abs(step):g}" in say(doubts[0]).replace("e+06", "").replace(".000", "") or step > 1e6


@pytest.mark.parametrize(("lost", "place", "again"), [(3.1, 0.35, True), (6.4, 0.62, False)])
def test_a_restart_is_two_turn_ons_and_the_labels_tell_what_passed(tmp_path, lost, place, again):
    one = made(13)
    cut = int(place * len(one.t))
    rows = np.r_[0:cut, cut + round(lost * 50.0) : len(one.t)]
    began = np.where(np.arange(len(rows)) < cut, 0.0, one.t[rows[cut]] - 0.02)
    stamps = one.t[rows] - began
    found, doubts = understood(
        tmp_path, one, readings(one)[rows], stamps=stamps, header_before=cut if again else None
    )
    assert codes(doubts)[0] == "restarted"
    passed, within = (float(str(argument(doubts[0], name))) for name in ("seconds", "within"))
    assert abs(passed - lost) <= within + 0.06
    later = found.imu.t[-1] - one.t[-1]
    assert abs(later) <= within + 0.06
    for label in found.manifest.segments or ():
        assert label.t_end <= one.t[cut] or label.t_start >= one.t[cut] + lost - 0.1


@pytest.mark.parametrize("named", [True, False])
def test_devices_that_take_turns_are_asked_for(tmp_path, named):
    one, other = made(14, 50.0), made(14, 50.0)
    other.accel, other.gyro = other.accel * 1.02 + 0.1, other.gyro * 1.01 - 0.01
    both = np.empty((2 * len(one.t), 6))
    both[::2], both[1::2] = readings(one), readings(other)
    table = np.column_stack([both, np.tile([3, 7], len(one.t))]) if named else both
    names = [*NAMES, "mux"] if named else NAMES
    asked = "column mux tells 2 sensors apart" if named else "each stamp has 2 rows"
    with pytest.raises(Unusable, match=asked + ".*which of them is to be read"):
        understood(tmp_path, one, table, stamps=np.repeat(one.t, 2), names=names)


def test_a_flag_that_takes_turns_tells_no_devices_apart(tmp_path):
    one = made(15)
    flags = np.arange(len(one.t)) % 2
    table = np.column_stack([readings(one), flags])
    assert not understood(tmp_path, one, table, names=[*NAMES, "sync"])[1]


@pytest.mark.parametrize(("triad", "of", "to"), [(ACCEL, 3, (5,)), (GYRO, 1, (0, 2))])
def test_copies_of_a_column_leave_the_triad_out(tmp_path, triad, of, to):
    one = made(16, 50.0)
    values = readings(one)
    values[:, list(to)] = values[:, [of]]
    found, doubts = understood(tmp_path, one, values)
    assert "column_copied" in codes(doubts)
    assert np.isnan(found.imu.stack(triad)).all()


@pytest.mark.parametrize(("axis", "rate", "hertz"), [("y", 90.0, 200.0), ("x", -40.0, 100.0)])
def test_rows_that_are_held_in_one_motion_make_it_suspect(tmp_path, axis, rate, hertz):
    one = made(17, hertz)
    label = next(s for s in one.labels if s.get("rate_deg_s") == rate and s.get("axis") == axis)
    values, rng = readings(one, 2), np.random.default_rng(1)
    for row in np.flatnonzero((one.t > label["t_start"]) & (one.t < label["t_end"])).tolist():
        if rng.random() < 0.4:
            values[row, :3] = values[row - 1, :3]
    _, doubts = understood(tmp_path, one, values)
    assert codes(doubts) == ["held_rows"]
    assert doubts[0].segments == (label["name"],)


def test_a_coarse_log_is_one_sentence_with_a_count(tmp_path):
    one = made(18)
    values = readings(one)
    values[:, :3] = np.round(values[:, :3] / 0.5) * 0.5
    _, doubts = understood(tmp_path, one, values)
    assert codes(doubts) == ["coarse_log"]
    assert "times, in" in say(doubts[0])


@pytest.mark.parametrize(
    ("first", "factor", "code"), [(0, 0.8, "rate_setting"), (0, 1.22, "rate_setting"),
                                  (3, 0.82, "force_setting"), (3, 13.9, "force_unit")]
)  # fmt: skip
def test_a_factor_of_a_triad_is_told_and_no_unit_is_made_up(tmp_path, first, factor, code):
    one = made(19)
    values = readings(one)
    values[:, first : first + 3] *= factor
    _, doubts = understood(tmp_path, one, values)
    assert codes(doubts) == [code]
    assert "--units" not in say(doubts[0])


@pytest.mark.parametrize(
    ("degrees", "about"), [(45.0, (0, 0, 1)), (30.0, (1, 1, 0)), (-55.0, (1, 0, 0))]
)
def test_a_unit_turned_by_what_no_exchange_of_axes_is_is_told(tmp_path, degrees, about):
    one = made(20)
    x, y, z = np.array(about) / np.linalg.norm(about)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(degrees)
    turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    one.gyro, one.accel = one.gyro @ turn.T, one.accel @ turn.T
    _, doubts = understood(tmp_path, one, readings(one))
    assert "mount" in codes(doubts)
    assert float(str(argument(doubts[codes(doubts).index("mount")], "degrees"))) == pytest.approx(
        abs(degrees), abs=2.0
    )


@pytest.mark.parametrize(("bits", "alone"), [(15, False), (16, True)])
def test_offset_binary_is_taken_off_exactly(tmp_path, bits, alone):
    one = made(21)
    right = counts(one)
    table = right + 2.0**bits * np.array([not alone] * 3 + [True] * 3)
    found, doubts = understood(tmp_path, one, table, names=COUNTS, units=RAW)
    assert set(codes(doubts)) == {"offset_binary"}
    mended = codes_put_right(offset_taken_off(found)).imu
    np.testing.assert_allclose(mended.stack(GYRO), right[:, :3] * DEG / 65.5, atol=1e-7)
    np.testing.assert_allclose(mended.stack(ACCEL), right[:, 3:] * G / 4096.0, atol=1e-6)


@pytest.mark.parametrize("places", [1, -1])
def test_fields_that_lie_one_too_far_are_told(tmp_path, places):
    one = made(22)
    table = np.roll(counts(one), places, axis=1)
    _, doubts = understood(tmp_path, one, table, names=COUNTS, units=RAW)
    assert "column_exchanged" in codes(doubts)


@pytest.mark.parametrize("ticks", [32768.0, 40000.0, 15360.0])
def test_stamps_in_ticks_are_asked_for(tmp_path, ticks):
    one = made(23)
    with pytest.raises(Unusable, match=r"may count ticks|in which unit"):
        understood(tmp_path, one, readings(one), stamps=np.rint(one.t * ticks), time="count_t")


@pytest.mark.parametrize("seed", range(10))
def test_a_table_without_a_fault_is_let_be(tmp_path, seed):
    rng = np.random.default_rng(seed)
    one = made(seed, (100.0, 20.0, 125.0, 50.0, 10.0)[seed % 5], poor=1.0 + seed % 2)
    values = readings(one, (4, 3)[seed % 2])
    rows, stamps = np.ones(len(one.t), bool), one.t
    if seed % 3 == 0:  # pauses between labels, and taps
        for label in one.labels[2:8:2]:
            rows &= ~((one.t > label["t_end"] + 0.4) & (one.t < label["t_end"] + 1.9))
        for row in rng.integers(0, len(one.t) - 2, 6).tolist():
            values[row : row + 2, 3:] += rng.normal(0, 60, (2, 3))
    if seed % 3 == 1:  # a range that is too small
        values[:, :3] = np.clip(values[:, :3], -85.0, 85.0)
    found, doubts = understood(tmp_path, one, values[rows], stamps=stamps[rows])
    assert codes(doubts) == []
    np.testing.assert_allclose(found.imu.t, one.t[rows], atol=1e-9)
    np.testing.assert_allclose(found.imu.stack(ACCEL), values[rows, 3:], atol=1e-9)
