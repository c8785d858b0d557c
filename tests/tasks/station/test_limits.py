"""A procedure against the limits of table and fixture."""

import pytest

from schemas.base import Unusable
from schemas.limits import Limits
from schemas.procedure import Procedure
from schemas.station import StationFile
from tasks.station import procedures
from tasks.station.limits import check_limits
from tasks.station.virtual.config import VirtualStation, station_file

JJF2003 = procedures.load("jjf2003")


def limited(limits: dict[str, object]) -> StationFile:
    station = station_file(VirtualStation(), 1.0, "nowhere", 1, 2)
    return station.model_copy(update={"limits": Limits.model_validate(limits)})


def outer(**limits: object) -> dict[str, object]:
    return {"axes": {"outer": limits}}


@pytest.mark.parametrize(
    "limits",
    [
        {},
        outer(rate_deg_s=1000.0, acceleration_deg_s2=2000.0),
        {"axes": {"middle": {"angle_deg": (-180.0, 270.0)}}},
    ],
)
def test_a_procedure_within_the_limits_is_let_through(limits):
    check_limits(JJF2003, limited(limits))


@pytest.mark.parametrize(
    ("limits", "sentence"),
    [
        (outer(rate_deg_s=5.0), r"needs \d+ deg/s \(limit 5\) about axis outer, and axis outer"),
        (outer(acceleration_deg_s2=1.0), r"needs \d+ deg/s2 \(limit 1\) about axis outer"),
        (outer(angle_deg=(-400.0, 400.0)), r"turns without end \(limit -400 to 400 deg\)"),
        (
            {"axes": {"middle": {"angle_deg": (-10.0, 10.0)}}},
            r"needs 90 deg \(limit -10 to 10 deg\) about",
        ),
        ({"fixture": {"rate_deg_s": 200.0}}, r"segment rate_x_\S+ .* and the fixture of station"),
        ({"axes": {"roll": {}}}, "names roll, and the table has the axes outer, middle, inner"),
    ],
)
def test_what_is_too_much_is_named_with_its_segment_and_limit(limits, sentence):
    with pytest.raises(Unusable, match=sentence):
        check_limits(JJF2003, limited(limits))


def test_turns_count_from_where_they_begin_to_where_they_end():
    values = procedures.load("jjf1536").model_dump()
    turns = next(step for step in values["steps"] if step["kind"] == "turns")
    only = Procedure.model_validate(values | {"steps": [turns]})
    axes = len(turns["angles_deg"])
    assert axes == 1
    station = station_file(VirtualStation(), 1.0, "nowhere", 1, 2)
    end = turns["angles_deg"][0] + 360.0 * turns["turns"]
    name = station.station.table_axes[0].name

    def check(most_deg: float) -> None:
        limits = Limits.model_validate({"axes": {name: {"angle_deg": (-end, most_deg)}}})
        check_limits(only, station.model_copy(update={"limits": limits}))

    check(end)
    with pytest.raises(Unusable, match=f"needs {end:g} deg"):
        check(end - 1.0)
