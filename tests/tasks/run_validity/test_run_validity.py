"""What is found of a run: segments, clocks, codes, the laboratory's latitude."""

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from schemas.calibration import Calibration
from schemas.recording import GYRO, Manifest, Recording, Stream
from schemas.text import Remark
from storage.catalogue import runs
from storage.formats.folder import read_folder
from storage.home import Home
from tasks.calibrate.calibrate import calibrate
from tasks.readings.plausibility import on_sight
from tasks.run_validity.clocks import clock_remarks
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.register import specification_for
from tasks.stages.estimate import estimate, validity_of
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.servers import station_file
from tests.manifests import at_station
from tests.shared import shared_path
from tests.tasks.items_only import items_only

# Each check names segment, channel and number.


def remarks(recording: Recording, code: str) -> list[Remark]:
    calibration = items_only(JJF2003, recording)
    return [remark for remark in calibration.remarks if remark.code == code]


def relabelled(recording: Recording, name: str, **changes: Any) -> Recording:
    segments = tuple(
        s.model_copy(update=changes) if s.name == name else s for s in recording.manifest.segments
    )
    manifest = recording.manifest.model_copy(update={"segments": segments})
    return replace(recording, manifest=manifest)


def moment(recording: Recording, name: str) -> tuple[float, float]:
    (segment,) = [s for s in recording.manifest.segments or () if s.name == name]
    return segment.t_start, segment.t_end


def edited(recording: Recording, name: str, edit: Callable[[dict, slice], None]) -> Recording:
    segment = next(s for s in recording.manifest.segments if s.name == name)
    columns = {key: values.copy() for key, values in recording.imu.columns.items()}
    edit(columns, recording.imu.rows(segment.t_start, segment.t_end))
    return replace(recording, imu=Stream(recording.imu.t, columns))


def test_of_a_clean_run_without_encoders_the_turns_alone_are_not_known(ideal_run):
    calibration = items_only(JJF2003, ideal_run())
    assert [r.code for r in calibration.remarks if r.blocks_pass] == ["no_reference"]


def test_a_position_that_gravity_contradicts_is_named_with_what_gravity_shows(ideal_run):
    recording = relabelled(ideal_run(), "position_+x_000", up="-x")
    (remark,) = remarks(recording, "position_contradicted")
    assert remark.segments == ("position_+x_000",)
    assert "accel_x reads +9.780" in remark.en
    assert "+x" in remark.zh
    assert remark.blocks_pass


def test_a_rate_the_gyro_contradicts_is_left_out_where_no_table_tells(ideal_run):
    recording = relabelled(ideal_run(), "rate_y_+100", rate_deg_s=150.0)
    (remark,) = remarks(recording, "rate_contradicted")
    assert "gyro_y shows +100.0000 deg/s" in remark.en
    scale = items_only(JJF2003, recording).items["gyro_scale_factor"]
    assert scale.value["y"] == pytest.approx(1.0, abs=1e-6)


def g_sensitive(recording: Recording) -> Recording:
    """With 0.5°/s per m/s² of each gyro, far above what a rest's gyro may differ by."""
    columns = dict(recording.imu.columns)
    for axis in "xyz":
        columns[f"gyro_{axis}"] = columns[f"gyro_{axis}"] + np.radians(0.5) * columns["accel_z"]
    return replace(recording, imu=Stream(recording.imu.t, columns))


@pytest.mark.parametrize("has_table", [True, False])
def test_a_large_g_sensitivity_does_not_make_rests_turn(plant, has_table):
    recording = g_sensitive(plant("plant_clean", 4))
    recording = recording if has_table else replace(recording, table=None)
    assert remarks(recording, "rest_turns") == []


def test_a_rest_that_turns_is_found_without_encoders_whatever_the_g_sensitivity(plant):
    def turn(columns: dict, rows: slice) -> None:
        columns["gyro_z"][rows] += np.radians(3.0)

    recording = edited(replace(g_sensitive(plant("plant_clean", 4)), table=None),
                       "position_+z_000", turn)  # fmt: skip
    (remark,) = remarks(recording, "rest_turns")
    assert remark.segments == ("position_+z_000",)


def laid_by_hand(recording: Recording, degrees: float) -> Recording:
    """Without encoders, and each rest tilted by that about one of its level axes."""
    found, tilt = replace(recording, table=None), np.radians(degrees)
    for number, segment in enumerate(s for s in found.manifest.segments if s.kind == "static"):
        up = "xyz".index(segment.up[1])
        level = (up + 1 + number % 2) % 3

        def tilted(columns: dict, rows: slice, up: int = up, level: int = level) -> None:
            names = f"accel_{'xyz'[up]}", f"accel_{'xyz'[level]}"
            a, b = (columns[name][rows].copy() for name in names)
            columns[names[0]][rows] = np.cos(tilt) * a - np.sin(tilt) * b
            columns[names[1]][rows] = np.sin(tilt) * a + np.cos(tilt) * b

        found = edited(found, segment.name, tilted)
    return found


def test_rests_laid_by_hand_are_tilted_and_their_zero_did_not_drift(plant):
    recording = laid_by_hand(plant("plant_clean", 4), 0.5)
    found = items_only(JJF2003, recording).remarks
    assert not {"drift", "unsteady_zero"} & {remark.code for remark in found}


def test_a_zero_that_jumped_is_found_in_rests_laid_by_hand(plant):
    def jump(columns: dict, rows: slice) -> None:
        columns["accel_z"][rows] += 0.2

    recording = edited(laid_by_hand(plant("plant_clean", 4), 0.5), "position_+z_000", jump)
    (remark,) = remarks(recording, "unsteady_zero")  # of the two with z up, both half of it off
    assert remark.segments[0].startswith("position_+z")


def test_a_rate_the_table_contradicts_is_replaced_by_the_tables(plant):
    recording = relabelled(plant("plant_clean", 4), "rate_y_+100", rate_deg_s=101.0)
    (remark,) = remarks(recording, "rate_contradicted")
    assert "the table shows +100.0000 deg/s" in remark.en
    honest = items_only(JJF2003, plant("plant_clean", 4))
    result = items_only(JJF2003, recording)
    found, known = result.items["gyro_scale_factor"], honest.items["gyro_scale_factor"]
    assert found.value == known.value
    # What comes back once a turn is taken from the noise at the rate of the label.
    assert list(found.u.values()) == pytest.approx(list(known.u.values()), rel=0.1)


def test_a_stuck_channel_is_named_with_its_value_and_length(plant):
    def stick(columns: dict, rows: slice) -> None:
        columns["gyro_z"][rows.start + 100 : rows.start + 700] = 0.25

    recording = edited(plant("plant_clean", 4), "rest_x", stick)
    (remark,) = remarks(recording, "stuck")
    assert remark.segments == ("rest_x",)
    assert "gyro_z was stuck at 0.25 for 600 rows" in remark.en


@pytest.mark.parametrize("codes", [0.6, 0.75, 1.0, 1.5, 2.1, 2.2, 3.7])
def test_noise_of_so_many_codes_is_no_outlier(plant, codes):
    recording = plant("plant_clean", 4)
    still = recording.imu.rows(*moment(recording, "position_+x_000"))
    columns = dict(recording.imu.columns)
    for name in GYRO:
        step = columns[name][still].std() / codes
        columns[name] = step * np.round(columns[name] / step)
    rounded = replace(recording, imu=Stream(recording.imu.t, columns))
    assert remarks(rounded, "samples_off") == []


def test_lost_samples_are_counted_with_the_longest_gap(plant):
    recording = plant("plant_clean", 4)
    segment = next(s for s in recording.manifest.segments if s.name == "rest_x")
    rows = recording.imu.rows(segment.t_start, segment.t_end)
    keep = np.ones(len(recording.imu), bool)
    keep[rows.start + 500 : rows.start + 520] = False
    columns = {name: values[keep] for name, values in recording.imu.columns.items()}
    (remark,) = remarks(
        replace(recording, imu=Stream(recording.imu.t[keep], columns)), "lost_samples"
    )
    assert "20 samples lost in 1 gap," in remark.en


def test_too_short_points_are_listed_with_their_length(ideal_run):
    (remark,) = remarks(ideal_run(dwell=20.0), "short_dwell")
    assert remark.blocks_pass
    assert "position_+x_000 20.0 s" in remark.en


def test_air_outside_clause_6_is_named_with_its_segment(ideal_run):
    recording = ideal_run()
    air = recording.environment
    hot = Stream(air.t, {**air.columns, "temperature": np.where(air.t < 45, 26.0, 20.0)})
    found = remarks(replace(recording, environment=hot), "environment")
    assert [r.segments[0] for r in found] == ["position_+x_000", "position_+x_180"]
    assert "26.0 °C is outside 15 to 25 °C" in found[0].en


def test_air_that_was_not_recorded_blocks_a_pass(ideal_run):
    (remark,) = remarks(replace(ideal_run(), environment=None), "environment_not_recorded")
    assert remark.blocks_pass


@pytest.mark.parametrize("factor", [np.pi / 180, 180 / np.pi])
def test_rates_in_the_wrong_unit_are_refused_with_the_factor(ideal_run, factor):
    recording = ideal_run()
    segments = tuple(
        s.model_copy(update={"rate_deg_s": s.rate_deg_s * factor}) if s.kind == "rate" else s
        for s in recording.manifest.segments
    )
    (remark,) = on_sight(recording, segments)
    assert (remark.code in ("label_unit", "rate_unit"), remark.run) == (True, "invalid")
    assert "57.3" in remark.en


def test_overlapping_segments_are_named(ideal_run):
    first = next(s for s in ideal_run().manifest.segments if s.name == "position_+x_000")
    changes = {"t_start": first.t_start, "t_end": first.t_end}
    recording = relabelled(ideal_run(), "position_+x_180", **changes)
    (remark,) = remarks(recording, "overlapping_segments")
    assert set(remark.segments) == {"position_+x_000", "position_+x_180"}
    assert remark.blocks_pass


@pytest.mark.parametrize(("beyond", "named"), [(0.4, 0), (500.0, 1)])
def test_a_segment_that_reaches_beyond_the_recording_is_named(beyond, named, ideal_run):
    recording = ideal_run()
    last = recording.manifest.segments[-1]
    later = relabelled(recording, last.name, t_end=float(recording.imu.t[-1]) + beyond)
    found = remarks(later, "beyond_recording")
    assert [remark.segments for remark in found] == [(last.name,)] * named
    for remark in found:
        assert "the recording was cut off" in remark.en
        assert last.name in remark.zh


def test_a_misspelt_field_is_named_with_what_may_be_meant(ideal_run):
    recording = ideal_run()
    fields = recording.manifest.model_dump(exclude_unset=True)
    assert remarks(recording, "misspelt_field") == []
    fields["station"] = {"id": "ST-1", "latitud_deg": 39.9, "operator": "L"}
    fields["segments"] = [each | {"rate_degs": 1.0} for each in fields["segments"]]
    misspelt = replace(recording, manifest=Manifest.model_validate(fields))
    found = [remark.en for remark in remarks(misspelt, "misspelt_field")]
    assert len(found) == 2
    assert "Field station.latitud_deg of the manifest is unknown" in found[0]
    assert "segments.rate_deg_s is absent" in found[1]


def test_a_misspelt_field_is_named_of_a_run_in_store_as_well(ideal_run, tmp_path):
    recording = ideal_run(dwell=1.0)
    station = {"id": "ST-1", "latitud_deg": 39.9, "heading_deg2": 1.0, "standards": "ours"}
    fields = recording.manifest.model_dump(exclude_unset=True) | {"station": station}
    misspelt = replace(recording, manifest=Manifest.model_validate(fields))
    run, _ = runs.add(misspelt, Home(tmp_path))
    (found,) = remarks(runs.load(run, Home(tmp_path)), "misspelt_field")
    assert "station.latitude_deg is absent" in found.en
    assert not found.blocks_pass


def test_a_share_of_lost_samples_is_told_apart_from_what_is_allowed(ideal_run):
    recording = ideal_run()
    rows = np.ones(len(recording.imu), bool)
    rows[:: round(1 / 0.014)] = False
    thinned = replace(recording, imu=recording.imu.at(rows))
    (found,) = remarks(thinned, "lost_share")
    assert "1.1 % of the samples" in found.en
    assert "1 % is allowed" in found.en


# The rates that a unit reads against those of the encoders, over time.

T = np.arange(0.0, 120.0, 0.01)
BIAS = np.radians([1.0, -2.0, 3.0])
RATE = np.radians(90.0)
RAMP_S = 0.75


def turned(t: np.ndarray, from_s: float) -> np.ndarray:
    """Angle (rad) of an axis that turns for 6 s from 20 s on, and from `from_s` to the end."""
    knots = np.array([20.0, 20.0 + RAMP_S, 26.0, 26.0 + RAMP_S, from_s, from_s + RAMP_S, 1e3])
    rates = RATE * np.interp(T, knots, [0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0])
    return np.interp(t, T, np.concatenate([[0.0], np.cumsum(rates[:-1] * 0.01)]))


@pytest.fixture
def recorded(ideal_run) -> Any:
    """A recording of that motion, whose unit is so many seconds late."""

    def make(from_s: float, late_s: float) -> ClauseEvidence:
        still = np.zeros(len(T))
        z = np.gradient(turned(T - late_s, from_s), 0.01)
        readings = np.array([still, still, z]).T + BIAS
        imu = Stream(T, dict(zip(GYRO, readings.T, strict=True)))
        angles = {"outer_angle": turned(T, from_s), "middle_angle": still, "inner_angle": still}
        manifest = ideal_run(dwell=1.0).manifest
        measured_by = station_file(VirtualStation(), 1.0, "host", 1, 2).station
        manifest = manifest.model_copy(update={"station": measured_by})
        recording = Recording(manifest, imu, Stream(T, angles), None, None)
        return cast(ClauseEvidence, SimpleNamespace(recording=recording))

    return make


@pytest.mark.parametrize("from_s", [35.0, 50.0, 95.0])
def test_clocks_agree_however_long_the_table_turns(from_s, recorded):
    assert list(clock_remarks(recorded(from_s, 0.0))) == []


@pytest.mark.parametrize("from_s", [35.0, 95.0])
@pytest.mark.parametrize("late_s", [-1.4, 0.3, 1.0])
def test_clocks_that_are_apart_make_the_run_invalid(late_s, from_s, recorded):
    (remark,) = clock_remarks(recorded(from_s, late_s))
    assert (remark.code, remark.run) == ("clocks_apart", "invalid")
    assert f"{late_s:+.2f} s" in remark.en


# What calibrate says of codes that were wrong, and what it does with them.

SIZE = 256


def calibrated(recording: Recording) -> Calibration:
    specification = specification_for(recording.manifest.standard)
    return calibrate(specification, recording, run="", code_version="")


def with_numbers(change: "object", step: float) -> Recording:
    """The plant's run with the numbers of gyro x changed, which it gives in steps."""
    recording = read_folder(shared_path("data/plant/plant_clean"))
    columns = dict(recording.imu.columns)
    numbers = np.rint(columns["gyro_x"] / step).astype(int)
    columns["gyro_x"] = change(numbers) * step  # type: ignore[operator]
    return replace(recording, imu=Stream(recording.imu.t, columns))


STEP = np.radians(1e-3)  # of the plant's gyros


def low_byte_signed(numbers: np.ndarray) -> np.ndarray:
    low = numbers & 0xFF
    return numbers - low + np.where(low >= SIZE // 2, low - SIZE, low)


def test_a_result_with_codes_put_right_is_that_of_the_right_codes_and_says_so():
    clean = calibrated(with_numbers(lambda numbers: numbers, STEP))
    mended = calibrated(with_numbers(low_byte_signed, STEP))
    for name, item in clean.items.items():
        assert mended.items[name].value == pytest.approx(item.value, rel=1e-9, abs=1e-12)
    (remark,) = [each for each in mended.remarks if each.code == "codes_put_right"]
    assert remark.run == "remarks"
    assert "low byte was joined as a signed number" in remark.en
    assert "低字节" in remark.zh
    assert not [each for each in clean.remarks if each.code.startswith("codes_")]


def test_a_bit_that_sticks_makes_the_run_invalid():
    stuck = calibrated(with_numbers(lambda numbers: numbers & ~64, STEP))
    (remark,) = [each for each in stuck.remarks if each.code == "codes_undecided"]
    assert remark.run == "invalid"
    assert stuck.validity.verdict == "invalid"
    assert "always clear" in remark.en


# The latitude of a recording against that of the laboratory.

LABORATORY = """
format = "mimu-laboratory/1"
latitude_deg = {latitude}
party = {{ name = "L", name_zh = "实", address = "a", address_zh = "址" }}
"""
SENTENCE = "The recording states a latitude of 39.9°, but that of the laboratory is -39.9°."


@pytest.fixture
def at_39_9(ideal_run) -> Recording:
    return at_station(ideal_run(dwell=1.0), latitude_deg=39.9)


@pytest.mark.parametrize(("own", "contradicted"), [(39.9, 0), (39.95, 0), (-39.9, 1)])
def test_a_latitude_that_is_not_the_laboratorys_makes_the_run_invalid(
    own, contradicted, at_39_9, tmp_path
):
    (tmp_path / "laboratory.toml").write_text(LABORATORY.format(latitude=own), encoding="utf-8")
    run, _ = runs.add(at_39_9, Home(tmp_path))
    about_latitude = [
        r for r in estimate(run, Home(tmp_path)).remarks if r.code == "laboratory_latitude"
    ]
    assert [remark.run for remark in about_latitude] == ["invalid"] * contradicted


def test_it_is_said_as_soon_as_the_run_is_there(at_39_9, tmp_path):
    (tmp_path / "laboratory.toml").write_text(LABORATORY.format(latitude=-39.9), encoding="utf-8")
    run, _ = runs.add(at_39_9, Home(tmp_path))
    assert SENTENCE in validity_of(run, Home(tmp_path)).reasons
