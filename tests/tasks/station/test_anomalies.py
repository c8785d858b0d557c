import numpy as np

from schemas.procedure import EnvironmentLimits
from schemas.recording import Segment, Stream
from tasks.station.monitor import Anomaly, check_rate, check_unit, remarks_on
from tests.tasks.station.sample_stations import rates_link

LIMITS = EnvironmentLimits(temperature_degc=(15.0, 25.0), humidity_percent=(20.0, 85.0))
LINK = rates_link()
SEGMENTS = (
    Segment(name="move000", kind="transition", t_start=0, t_end=10),
    Segment(name="rest_x", kind="static", t_start=10, t_end=20),
    Segment(name="rate_x_+10", kind="rate", t_start=20, t_end=30, axis="x", rate_deg_s=10),
)


def noisy_unit(rows: int = 1000) -> Stream:
    names = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")
    noise = np.random.default_rng(1).normal(0.0, 1e-3, (rows, 6))
    columns = {name: noise[:, place].copy() for place, name in enumerate(names)}
    return Stream(10 + np.arange(rows) / 100, columns)


def test_air_out_of_limits_in_a_measured_segment_blocks_a_pass():
    reports = [Anomaly("air_temperature", 12.0, 12.0, 26.0), Anomaly("air_temperature", 5, 5, 27.0)]
    (remark,) = remarks_on(reports, SEGMENTS, LIMITS)
    assert remark.en == (
        "The air temperature was 26.0 to 27.0 °C; the procedure allows 15–25 °C (in rest_x)."
    )
    assert remark.zh == "环境温度为 26.0～27.0 °C，超出校准程序允许的 15–25 °C（rest_x）。"
    assert remark.segments == ("rest_x",)
    assert remark.blocks_pass


def test_air_out_of_limits_between_segments_blocks_nothing():
    (remark,) = remarks_on([Anomaly("air_humidity", 5.0, 5.0, 90.0)], SEGMENTS, LIMITS)
    assert "allows 20–85 %RH (between the measured segments)" in remark.en
    assert not remark.blocks_pass


def test_what_lies_across_a_border_belongs_to_both_segments():
    (remark,) = remarks_on([Anomaly("encoder_gap", 19.9, 20.1, 20)], SEGMENTS, LIMITS)
    assert remark.segments == ("rest_x", "rate_x_+10")


def test_each_channel_has_its_own_remark():
    reports = [Anomaly("spikes", 12.0, 12.0, 2, "gyro_x"), Anomaly("spikes", 25, 25, 3, "accel_z")]
    remarks = remarks_on(reports, SEGMENTS, LIMITS)
    assert [remark.segments for remark in remarks] == [("rate_x_+10",), ("rest_x",)]
    assert "2 spikes" in remarks[1].en


def test_stuck_channel_and_spikes_are_found():
    imu = noisy_unit()
    imu.columns["gyro_y"][:] = 0.25
    imu.columns["accel_z"][[100, 700]] += 1.0
    found = check_unit(SEGMENTS[1], imu, LINK)
    assert [(f.code, f.subject, f.amount) for f in found] == [
        ("stuck_channel", "gyro_y", 1.0),
        ("spikes", "accel_z", 2),
    ]


def test_rate_off_by_a_thousandth_is_found_from_the_encoders():
    t = 20 + np.arange(1001) / 100
    exact, off = (Stream(t, {"outer_angle": np.radians(r) * t}) for r in (10.0, 10.01))
    assert check_rate(SEGMENTS[2], "outer", exact) == []
    (finding,) = check_rate(SEGMENTS[2], "outer", off)
    assert round(finding.amount, 6) == 0.1
