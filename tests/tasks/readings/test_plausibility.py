"""What a recording cannot be is told in one sentence that names it, and a clean one is let be."""

from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest

from schemas.recording import ANGLE, GYRO, Recording
from schemas.text import Remark
from storage.formats import recordings
from storage.formats.convert import Changes, axis_map, changed, pairs
from tasks.motion.encoders import as_mean_rates
from tasks.readings.axes import matrix_of_directions
from tasks.readings.codes import codes_put_right
from tasks.readings.plausibility import KINDS, on_sight, wrong_axes
from tasks.readings.rows import rows_without_readings
from tasks.segments.find import segments_of
from tasks.stages.import_recording import label_doubts
from tasks.words import argument, say
from tests.shared import shared_path
from tests.tasks.readings.makers import mistakes
from tests.tasks.readings.makers.bench import Bench, bench
from tests.tasks.readings.makers.recorded import recorded

HERTZ = (100.0, 25.0, 200.0, 10.0)
KNOWN = {"both": (True, True), "labels": (False, True), "table": (True, False)}
ONE = np.diag([1.0, 1.0, -1.0])
SWAPPED = np.eye(3)[[1, 0, 2]]
G0 = 9.80665
Mistake = Callable[[Bench], None]
MISTAKES: dict[str, tuple[Mistake, str]] = {
    "rates in °/s": (partial(mistakes.gyro_times, factor=180 / np.pi), "--units gyro=deg/s"),
    "rates converted twice": (
        partial(mistakes.gyro_times, factor=np.pi / 180), "--units gyro=57.2958rad/s",
    ),
    "rates divided twice": (
        partial(mistakes.gyro_times, factor=1 / 65.5), "--units gyro=65.5rad/s",
    ),
    "raw rates": (
        partial(mistakes.gyro_times, factor=131 * 180 / np.pi, whole=True),
        "--units gyro=131/dps",
    ),
    "forces in g": (partial(mistakes.accel_times, factor=1 / G0), "--units accel=g"),
    "forces in mg": (partial(mistakes.accel_times, factor=1e3 / G0), "--units accel=mg"),
    "raw forces": (
        partial(mistakes.accel_times, factor=8192 / G0, whole=True), "--units accel=8192/g",
    ),
    "no gravity": (mistakes.gravity_removed, ""),
    "time in ms": (partial(mistakes.time_times, factor=1e3), "--units t=ms"),
    "gyro z inverted": (partial(mistakes.gyro_mapped, matrix=ONE), "--axes gyro_z=-gyro_z"),
    "accelerometers inverted": (
        partial(mistakes.accel_mapped, matrix=-np.eye(3)),
        "--axes accel_x=-accel_x,accel_y=-accel_y,accel_z=-accel_z",
    ),
    "axes exchanged": (partial(mistakes.both_mapped, matrix=SWAPPED), "--axes x=y,y=x"),
}  # fmt: skip


def varied(seed: int) -> Bench:
    """One that a mistake may be made in."""
    return deepcopy(drawn(seed))


@cache
def drawn(seed: int) -> Bench:
    return bench(
        seed, hertz=HERTZ[seed % 4], dwell=(5.0, 8.0)[seed % 2], lever=0.05 * (seed % 2),
        rates=((50.0, 150.0), (30.0,))[seed % 2], turns=((0.0,), (0.0, 180.0))[seed % 2],
        margin=(0.0, 0.4)[seed % 2], poor=1.0 + seed % 3,
    )  # fmt: skip


def found(recording: Recording) -> tuple[Remark, ...]:
    return on_sight(recording, segments_of(recording))


def option(one: Remark) -> str:
    return str(argument(one, "option") or "")


@pytest.mark.parametrize("seed", range(12))
def test_a_clean_recording_is_let_be(seed):
    for table, labels in (*KNOWN.values(), (False, False)):
        assert found(recorded(varied(seed), table=table, labels=labels)) == ()


@pytest.mark.parametrize("known", KNOWN)
@pytest.mark.parametrize("name", MISTAKES)
def test_one_sentence_names_the_mistake_and_the_way_to_import_it_right(name, known):
    make, right = MISTAKES[name]
    for seed in (3, 6):
        made = varied(seed)
        make(made)
        table, labels = KNOWN[known]
        (one,) = found(recorded(made, table=table, labels=labels))
        assert option(one) == right
        assert one.code in KINDS
        for language in ("en", "zh"):
            assert right in say(one, language)


@pytest.mark.parametrize("number", range(len(mistakes.PROPER)))
def test_a_unit_turned_as_a_whole_is_imported_right_by_what_is_said(number):
    made = varied(number)
    right = made.gyro.copy()
    mistakes.both_mapped(made, mistakes.PROPER[number])
    turned = recorded(made, table=number % 2 == 0)
    (one,) = found(turned)
    changes = Changes(axes=axis_map(option(one).removeprefix("--axes ")))
    again = changed(turned, changes)
    np.testing.assert_allclose(again.imu.stack(("gyro_x", "gyro_y", "gyro_z")), right)
    assert found(again) == ()


@pytest.mark.parametrize("seconds", [0.5, -0.5, 10.0, -7.3, 31.0])
def test_labels_shifted_as_a_whole_are_put_right_by_what_is_said(seconds):
    for seed, table in ((2, False), (4, True)):
        made = varied(seed)
        mistakes.labels_late(made, seconds)
        late = recorded(made, table=table)
        (one,) = found(late)
        assert one.code == "labels_shifted"
        shift = float(option(one).removeprefix("--shift "))
        assert shift == pytest.approx(-seconds, abs=0.2)
        assert found(changed(late, Changes(shift=shift))) == ()


def test_a_table_in_degrees_is_not_taken_for_the_gyros():
    for labels in (True, False):
        made = varied(4)
        made.angle *= 180.0 / np.pi
        (one,) = found(recorded(made, table=True, labels=labels))
        assert option(one) == "--units table=deg"


def test_angles_in_degrees_are_advised_as_angles():
    recording = recorded(varied(3))
    imu, columns = recording.imu, dict(recording.imu.columns)
    turned = [np.cumsum(columns.pop(name)) * np.median(np.diff(imu.t)) for name in GYRO]
    columns |= dict(zip(ANGLE, np.degrees(turned), strict=True))
    of_angles = replace(recording, imu=replace(imu, columns=columns))
    assert [option(one) for one in found(as_mean_rates(of_angles))] == ["--units angle=deg"]


@pytest.mark.parametrize(
    ("seed", "table", "kept"),
    [*((seed, False, 2) for seed in range(1, 12, 2)), (8, False, 6), (8, True, 6)],
)
def test_a_position_that_is_labelled_wrongly_is_named_and_no_axis_with_it(seed, table, kept):
    made = varied(seed)
    rests = [label for label in made.labels if label["kind"] == "static"]
    wrong = next(rest for rest in rests if rest["up"] == "+x")
    others = [rest for rest in rests if rest["up"] == "+x" and rest is not wrong]
    made.labels = [wrong, *(others if kept == 2 else [one for one in rests if one is not wrong])]
    wrong["up"] = "+z"
    recording = recorded(made, table=table)
    assert found(recording) == ()
    (sentence,) = label_doubts(recording, ())
    assert f"{wrong['name']} (labelled +z up; gravity shows +x)" in sentence


def test_two_rests_that_read_alike_show_no_axis():
    """Level to a milliradian, along the diagonal that a turn as a whole would turn (x − z) to."""
    read = np.array([[1.0, 1e-3, 1e-3], [1.0, -1e-3, -1e-3]])
    assert wrong_axes(None, matrix_of_directions(read, np.eye(3)[[0, 2]])) is None


def test_what_is_said_is_what_import_takes():
    made = varied(7)
    mistakes.gyro_times(made, 65.5 * 180 / np.pi, whole=True)
    raw = recorded(made)
    (one,) = found(raw)
    units = pairs("--units", option(one).removeprefix("--units "), ("gyro",))
    assert found(changed(raw, Changes(units=units))) == ()


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("field/gravity_removed", ["gravity_removed"]),
        ("field/gyro_z_inverted_labels_only", ["axes"]),
        ("field/time_in_ms", ["time_unit"]),
        ("field/gyro_range_1137", ["rate_setting"]),
        ("rough/sunsided_turns", ["axes"]),
        # its labels +x, -x, +y, -y are those of a unit turned by 180° about z
        ("real/vn200_57630_six_position", ["axes"]),
    ],
)
def test_recordings_from_the_field_are_named(name, kinds):
    assert [one.code for one in found(recordings.read(shared_path(f"data/{name}")))] == kinds


NAMED = {"gravity_removed", "gyro_z_inverted_labels_only", "time_in_ms", "sunsided_turns",
         "vn200_57630_six_position", "gyro_range_1137"}  # fmt: skip
JOINED = {"bmi160_board1": 256.0}  # low bytes signed; those of data/field stand in test_codes
TORN = {"vn200_imu1_rate_table": 1}  # frames, of one row each


@pytest.mark.parametrize("folder", ["real", "rough", "plant", "field"])
def test_of_recordings_of_others_nothing_is_said_that_is_not_known_of_them(folder):
    every = [path.parent for path in sorted(shared_path(f"data/{folder}").glob("*/manifest.json"))]
    assert len(every) > 6
    for path in every:
        right = codes_put_right(as_mean_rates(recordings.read(path)))
        if path.name not in NAMED:
            assert found(right) == (), path.name
        if folder != "field":
            bugs = {(one.bug, one.codes) for one in right.wrong_codes}
            assert bugs == {("signed-low", code) for code in [JOINED.get(path.name)] if code}
            assert len(right.wrong_codes) == (6 if bugs else 0)
            assert rows_without_readings(right).sum() == TORN.get(path.name, 0)
